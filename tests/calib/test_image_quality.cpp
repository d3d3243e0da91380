#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/image_quality.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

struct ReadQuality {
  ImageQuality quality;
  std::string problems;
};
ReadQuality read_quality(const std::string& keys) {
  const auto root = ConfigTable::parse("[scene]\n" + keys, "kasumi.toml").value();
  auto quality = read_image_quality(root.table("scene"));
  const auto finished = root.finish();
  return {quality, finished ? "" : finished.error().message};
}

TEST(ImageQualityKeys, WithoutThemTheObjectIsSharpAndNoiseless) {
  const auto [quality, problems] = read_quality("");
  EXPECT_EQ(problems, "");
  EXPECT_EQ(quality.point_spread_px, 0.0);
  EXPECT_EQ(quality.full_scale_electrons, 0.0);
  EXPECT_EQ(quality.read_electrons, 0.0);
  EXPECT_FALSE(quality.shared_chroma);
  EXPECT_EQ(quality.sharpening, 0.0);
  EXPECT_FALSE(quality.jpeg_blocks);
}

TEST(ImageQualityKeys, AreReadAsWritten) {
  const auto [quality, problems] = read_quality(
      "point_spread_px = 0.55\nsharpening = 0.9\nshared_chroma = true\njpeg_blocks = "
      "true\n[scene.noise]\nfull_scale_electrons = 9000\nread_electrons = 4\n");
  EXPECT_EQ(problems, "");
  EXPECT_EQ(quality.point_spread_px, 0.55);
  EXPECT_TRUE(quality.shared_chroma);
  EXPECT_EQ(quality.sharpening, 0.9);
  EXPECT_TRUE(quality.jpeg_blocks);
  EXPECT_EQ(quality.full_scale_electrons, 9000.0);
  EXPECT_EQ(quality.read_electrons, 4.0);
}

TEST(ImageQualityKeys, ReportAllProblemsAtOnce) {
  const auto [quality, problems] =
      read_quality("point_spread_px = 3.1\nshared_chroma = 1\n[scene.noise]\nread_electrons = 4\nelectrons = 3\n");
  for (const char* words : {"scene.point_spread_px = 3.1", "scene.shared_chroma = 1",
                            "scene.noise.full_scale_electrons is missing", "scene.noise.electrons: unknown key"})
    EXPECT_THAT(problems, HasSubstr(words));
  EXPECT_THAT(read_quality("[scene.noise]\nread_electrons = -1\n").problems,
              HasSubstr("scene.noise.read_electrons = -1"));
}

}  // namespace
}  // namespace kasumi
