// Real pictures whose sky is obvious to a person. Overlays are left in the test output folder for inspection.
#include <filesystem>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "estimator/horizon/horizon.hpp"
#include "tests/opencv_pictures.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

const std::filesystem::path kHaze = shared_data_folder() / "haze";

void save_overlay(const Image<Rgb8>& picture, const Image<std::uint8_t>& sky, const std::string& name) {
  Image<Rgb8> overlay = picture;
  for (std::size_t i = 0; i < sky.elements().size(); ++i)
    if (auto& red = overlay.elements()[i].r; sky.elements()[i] != 0)
      red = static_cast<std::uint8_t>(100 + red * 155 / 255);
  std::filesystem::create_directories(test_output_folder());
  cv::imwrite(test_output_folder().string() + "/sky-" + name + ".png", bgr_of(overlay));
}

TEST(HorizonPictures, TheSkyEndsAtTheHazyGatesRoof) {
  const auto path = kHaze / "classic" / "tiananmen.png";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
  const Image<Rgb8> picture = read_rgb(path);  // 600x450
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
    const Image<Rgb8> picture =
        read_rgb(kHaze / "knmi-debilt" / (name + ".jpg"));  // 768x576, tree tops at rows 270-295
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
