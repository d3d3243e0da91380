// A clear winter sky over Alpnach, thirteen exposures; see the shared data's README.
#include <filesystem>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "estimator/sky_camera/sun_in_image.hpp"
#include "estimator/turbidity/turbidity.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

class Alpnach : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(file(8))) GTEST_SKIP() << "no shared data: " << file(8);
  }
  static std::string file(int exposure) {
    return fmt::format("{}/sky/skycam-alpnach/Alpnach_20180129_11-09-20_ExposureStack_Image_{:02}_image.png",
                       shared_data_folder().string(), exposure);
  }
  static Camera camera(double field_of_view_deg) {
    Camera camera;
    camera.name = "sky";
    camera.width = camera.height = 300;
    const double half = from_degrees(field_of_view_deg / 2).value;
    camera.lens = equidistant_lens({149.6, 140.7}, 133.0 / half, {half});
    camera.to_world = camera_to_world(from_degrees(180), from_degrees(90), {0});
    camera.response = Response::linear();
    return camera;
  }
  static Result<SkyPicture> picture(int exposure, const Camera& camera) {
    const cv::Mat image = cv::imread(file(exposure), cv::IMREAD_COLOR);
    Image<Rgb8> rgb(image.cols, image.rows);
    for (int y = 0; y < image.rows; ++y)
      for (int x = 0; x < image.cols; ++x) {
        const auto& bgr = image.at<cv::Vec3b>(y, x);
        rgb.at(x, y) = {bgr[2], bgr[1], bgr[0]};
      }
    return sky_picture(view_of(rgb), camera);
  }
};

TEST_F(Alpnach, ExposuresEightAndNineGiveOneTurbidityBetweenTwoAndTwoPointSix) {
  for (const double field_of_view : {180.0, 185.0, 190.0}) {
    const Camera cam = camera(field_of_view);
    const SunDirection sun = *cam.direction_at({83.3, 80.9});
    const TurbidityEstimate a = estimate_turbidity(*picture(8, cam), cam, sun);
    const TurbidityEstimate b = estimate_turbidity(*picture(9, cam), cam, sun);
    std::printf("%.0f deg: exposure 8: %.3f +- %.3f (residual %.3f), exposure 9: %.3f +- %.3f (residual %.3f)\n",
                field_of_view, a.turbidity.value, a.sigma, a.log_residual, b.turbidity.value, b.sigma, b.log_residual);
    for (const TurbidityEstimate& e : {a, b}) {
      EXPECT_TRUE(e.usable) << e.reason;
      EXPECT_GT(e.turbidity.value, 2.0);
      EXPECT_LT(e.turbidity.value, 2.6);
    }
    EXPECT_LT(std::abs(a.turbidity.value - b.turbidity.value), a.sigma + b.sigma);
  }
}

TEST_F(Alpnach, OtherExposuresAgreeOrAreRefusedForTheirExposure) {
  const Camera cam = camera(185.0);
  const SunDirection sun = *cam.direction_at({83.3, 80.9});
  for (int exposure = 0; exposure < 13; ++exposure) {
    const TurbidityEstimate e = estimate_turbidity(*picture(exposure, cam), cam, sun);
    std::printf("exposure %2d: %s\n", exposure,
                e.usable ? fmt::format("T {:.2f} +- {:.2f}, {}, clear {:.2f}, residual {:.3f}", e.turbidity.value,
                                       e.sigma, name_of(e.sky), e.clear_fraction, e.log_residual)
                               .c_str()
                         : e.reason.c_str());
    if (e.usable) {
      EXPECT_NEAR(e.turbidity.value, 2.25, 0.3);
    } else {
      EXPECT_NE(e.reason.find("exposed"), std::string::npos) << e.reason;
      EXPECT_EQ(e.sky, SkyCondition::unknown);
    }
  }
}

TEST_F(Alpnach, TheSunIsWhereTheReadmeSays) {
  const Camera cam = camera(185.0);
  const SunDirection expected = *cam.direction_at({83.3, 80.9});
  for (const int exposure : {3, 4, 5, 6, 7}) {
    const auto blob = find_sun(*picture(exposure, cam), cam);
    ASSERT_TRUE(blob) << "exposure " << exposure;
    std::printf("exposure %d: sun at (%.2f, %.2f), radius %.2f deg, confidence %.2f\n", exposure, blob->pixel.x,
                blob->pixel.y, to_degrees(blob->radius), blob->confidence);
    EXPECT_LT(to_degrees(angle_between(blob->direction, expected)), 1.0) << "exposure " << exposure;
  }
}

}  // namespace
}  // namespace kasumi
