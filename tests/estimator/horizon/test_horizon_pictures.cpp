// Real pictures whose sky is obvious to a person. Overlays are left in the test output folder for inspection.
#include <filesystem>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "estimator/horizon/horizon.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

const std::filesystem::path kHaze = shared_data_folder() / "haze";

Image<Rgb8> read(const std::filesystem::path& path) {
  cv::Mat read = cv::imread(path.string(), cv::IMREAD_COLOR);
  Image<Rgb8> picture(read.cols, read.rows);
  for (int y = 0; y < read.rows; ++y) {
    for (int x = 0; x < read.cols; ++x) {
      const auto& bgr = read.at<cv::Vec3b>(y, x);
      picture.at(x, y) = {bgr[2], bgr[1], bgr[0]};
    }
  }
  return picture;
}

void save_overlay(const Image<Rgb8>& picture, const Image<std::uint8_t>& sky, const std::string& name) {
  cv::Mat overlay(picture.height(), picture.width(), CV_8UC3);
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      const Rgb8& rgb = picture.at(x, y);
      const auto red = static_cast<std::uint8_t>(sky.at(x, y) != 0 ? 100 + rgb.x * 155 / 255 : rgb.x);
      overlay.at<cv::Vec3b>(y, x) = {rgb.z, rgb.y, red};
    }
  }
  std::filesystem::create_directories(test_output_folder());
  cv::imwrite(test_output_folder().string() + "/sky-" + name + ".png", overlay);
}

TEST(HorizonPictures, TheSkyEndsAtTheHazyGatesRoof) {
  const auto path = kHaze / "classic" / "tiananmen.png";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
  const Image<Rgb8> picture = read(path);  // 600x450
  const SkySegmentation found = segment_sky(picture);
  save_overlay(picture, found.sky, "tiananmen");
  ASSERT_TRUE(found.visible) << found.reason;
  EXPECT_NE(found.sky.at(20, 20), 0);
  EXPECT_NE(found.sky.at(590, 200), 0);  // right of the roof
  EXPECT_NE(found.sky.at(300, 40), 0);   // above it
  EXPECT_EQ(found.sky.at(180, 100), 0);  // the gable
  EXPECT_EQ(found.sky.at(400, 200), 0);  // the storey below
  EXPECT_EQ(found.sky.at(300, 350), 0);  // the red wall
  EXPECT_NEAR(found.sky_fraction, 0.33, 0.05);
}

TEST(HorizonPictures, TheSkyOverAMeadowEndsAtItsTreesFromMistToClearAir) {
  if (!std::filesystem::exists(kHaze)) GTEST_SKIP() << kHaze << " is not there";
  for (const std::string name : {"Meetterrein_20151006_0620", "Meetterrein_20151006_1430", "Meetterrein_20151007_0650",
                                 "Meetterrein_20151007_1310", "Meetterrein_20151008_1620", "Meetterrein_20151010_0830",
                                 "Meetterrein_20151017_0630"}) {  // 1.6, 14, 19, 23, 48, 9.7, .47 km of visibility
    const Image<Rgb8> picture = read(kHaze / "knmi-debilt" / (name + ".jpg"));  // 768x576, tree tops at rows 270-295
    const SkySegmentation found = segment_sky(picture);
    save_overlay(picture, found.sky, name);
    ASSERT_TRUE(found.visible) << name << ": " << found.reason;
    int low_sky = 0, trees = 0;
    for (int x = 40; x < 728; ++x) {
      low_sky += found.sky.at(x, 215) != 0 ? 1 : 0;
      trees += found.sky.at(x, 330) == 0 ? 1 : 0;
    }
    EXPECT_GT(low_sky, 0.95 * 688) << name;
    EXPECT_GT(trees, 0.99 * 688) << name;
  }
}

}  // namespace
}  // namespace kasumi
