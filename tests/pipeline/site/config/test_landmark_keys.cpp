// [[landmarks]] that name a ridge, or take their distance from the scene's distance map.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/site/config/depth_map_landmarks.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

constexpr int kWide = 240, kHigh = 120;

// Sky, then hills 8 km, 3 km and 1 km away, each level and 20 rows high, then a meadow that comes nearer.
Image<float> hills() {
  Image<float> distances_m(kWide, kHigh, 0.0F);
  for (int y = 40; y < kHigh; ++y)
    for (int x = 0; x < kWide; ++x)
      distances_m.at(x, y) = y < 60    ? 8000.0F
                             : y < 80  ? 3000.0F
                             : y < 100 ? 1000.0F
                                       : 800.0F - 30.0F * static_cast<float>(y - 100);
  return distances_m;
}

struct KeysRead {
  std::vector<ContrastLandmark> landmarks;
  std::string problems;
};
KeysRead read_keys(const std::string& keys, const Image<float>* distances_m = nullptr) {
  const auto root = ConfigTable::parse("[[landmarks]]\nname = \"hill\"\n" + keys, "kasumi.toml").value();
  KeysRead all{read_contrast_landmarks(root, std::nullopt, {kWide, kHigh, nullptr, distances_m}), {}};
  if (const auto done = root.finish(); !done) all.problems = done.error().message;
  return all;
}

TEST(LandmarkKeys, ARidgeIsAStripBelowALine) {
  const auto found = read_keys("distance_m = 3000\nridge_px = [10, 61, 100, 65, 200, 60]\nstrip_px = 5\n");
  ASSERT_EQ(found.problems, "");
  ASSERT_EQ(found.landmarks.size(), 1U);
  const auto& landmark = found.landmarks.front();
  ASSERT_TRUE(landmark.ridge);
  EXPECT_EQ(landmark.ridge->line.size(), 3U);
  EXPECT_EQ(landmark.ridge->height_px, 5.0);
  EXPECT_EQ(landmark.surface.x, 10);
  EXPECT_EQ(landmark.surface.width, 191);
  EXPECT_EQ(landmark.distance_m, 3000.0);
}

TEST(LandmarkKeys, AContrastIsStatedWhereItsKeyIs) {
  const std::string place = "distance_m = 3000\nregion_px = [10, 60, 20, 10]\n";
  EXPECT_FALSE(read_keys(place).landmarks.at(0).contrast_stated);
  EXPECT_TRUE(read_keys(place + "contrast = 0.94\n").landmarks.at(0).contrast_stated) << "though as by default";
}

TEST(LandmarkKeys, TheDistanceMapGivesWhatIsNotGiven) {
  const auto map = hills();
  const auto ridge = read_keys("ridge_px = [10, 60, 200, 60]\nstrip_px = 5\n", &map);
  ASSERT_EQ(ridge.problems, "");
  EXPECT_EQ(ridge.landmarks.front().distance_m, 3000.0);
  const auto box = read_keys("region_px = [10, 82, 30, 10]\n", &map);
  ASSERT_EQ(box.problems, "");
  EXPECT_EQ(box.landmarks.front().distance_m, 1000.0);
  EXPECT_EQ(read_keys("region_px = [10, 82, 30, 10]\ndistance_m = 950\n", &map).landmarks.front().distance_m, 950.0)
      << "what is given goes before";
}

TEST(LandmarkKeys, HillsOfKnownDistanceNeedNoBoxes) {
  const auto map = hills();
  const auto found = read_keys("from_depth_map = 3\n", &map);
  ASSERT_EQ(found.problems, "");
  ASSERT_EQ(found.landmarks.size(), 3U);
  EXPECT_EQ(found.landmarks[0].distance_m, 1000.0);
  EXPECT_EQ(found.landmarks[1].distance_m, 3000.0);
  EXPECT_EQ(found.landmarks[2].distance_m, 8000.0);
  for (const auto& one : found.landmarks) {
    EXPECT_THAT(one.name, HasSubstr("hill, "));
    EXPECT_GT(one.contrast_sigma, ContrastLandmark{}.contrast_sigma) << "what they are made of is not known";
  }
}

TEST(LandmarkKeys, WhatIsWrongIsSaid) {
  const auto map = hills();
  EXPECT_THAT(read_keys("ridge_px = [10, 60, 200, 60]\n").problems, HasSubstr("distance_m"));
  EXPECT_THAT(read_keys("distance_m = 3000\nridge_px = [10, 60, 200]\n").problems, HasSubstr("from left to right"));
  EXPECT_THAT(read_keys("distance_m = 3000\nridge_px = [200, 60, 10, 60]\n").problems, HasSubstr("from left to right"));
  EXPECT_THAT(read_keys("distance_m = 3000\nridge_px = [10, 60, 200, 118]\nstrip_px = 5\n").problems,
              HasSubstr("240 x 120"));
  EXPECT_THAT(read_keys("distance_m = 3000\nridge_px = [10, 60, 200, 60]\nregion_px = [1, 1, 5, 5]\n").problems,
              HasSubstr("not both"));
  EXPECT_THAT(read_keys("distance_m = 3000\n").problems, HasSubstr("region_px"));
  EXPECT_THAT(read_keys("region_px = [10, 50, 30, 20]\n", &map).problems, HasSubstr("3000 to 8000 m"));
  EXPECT_THAT(read_keys("region_px = [10, 5, 30, 20]\n", &map).problems, HasSubstr("depth_map that knows it"));
  EXPECT_THAT(read_keys("from_depth_map = 3\n").problems, HasSubstr("a [scene] with a depth_map"));
  EXPECT_THAT(read_keys("from_depth_map = 0\n", &map).problems, HasSubstr("from_depth_map"));
}

}  // namespace
}  // namespace kasumi
