// A photographed sky.

#include <gtest/gtest.h>

#include "estimator/sky_camera/sun_in_image.hpp"
#include "estimator/turbidity/turbidity.hpp"
#include "tests/alpnach.hpp"
#include "tests/opencv_pictures.hpp"

namespace kasumi {
namespace {

class Alpnach : public testing::Test {
 protected:
  void SetUp() override {
    if (!alpnach::is_there()) GTEST_SKIP() << "no shared data: " << alpnach::file(0);
  }
  static Result<SkyPicture> picture(int exposure, const Camera& camera) {
    return sky_picture(view_of(read_rgb(alpnach::file(exposure))), camera);
  }
};

TEST_F(Alpnach, ExposuresEightAndNineGiveOneTurbidityBetweenTwoAndTwoPointSix) {
  for (const double field_of_view : {180.0, 185.0, 190.0}) {
    const Camera cam = alpnach::camera(field_of_view);
    const SunDirection sun = *cam.direction_at(alpnach::kSun);
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
  const Camera cam = alpnach::camera();
  const SunDirection sun = *cam.direction_at(alpnach::kSun);
  for (int exposure = 0; exposure < alpnach::kExposures; ++exposure) {
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
  const Camera cam = alpnach::camera();
  const SunDirection expected = *cam.direction_at(alpnach::kSun);
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
