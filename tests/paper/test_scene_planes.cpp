// Ground and walls, against the geometry of a pinhole.
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/files.hpp"
#include "base/geometry.hpp"
#include "calib/mask/scene_planes.hpp"
#include "estimator/photograph/other_air.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

constexpr int kWidth = 201, kHeight = 101;
const Camera& camera() {
  static const Camera looking_north = plain_camera(kWidth, kHeight, from_degrees(40.0), Radians{0.0});
  return looking_north;
}
const double kFocal_px = 0.5 * kWidth / std::tan(from_degrees(20.0).value);

TEST(ScenePlanes, GroundDistanceFollowsFromTheCamerasHeight) {
  const auto distances = distances_to({12.0, {}}, camera());
  for (const int y : {51, 60, 75, 100})
    for (const int x : {0, 100, 180}) {
      // The ground's depth is h f / (y - 50); the distance along the line of sight is longer by the ray's slant.
      const double off_x = x - 100, off_y = y - 50;
      const double expected = 12.0 / off_y * std::sqrt(kFocal_px * kFocal_px + off_x * off_x + off_y * off_y);
      EXPECT_NEAR(static_cast<double>(distances.at(x, y)) / expected, 1.0, 1e-5) << x << ", " << y;
    }
  EXPECT_EQ(distances.at(100, 50), 0.0F) << "the horizon is sky";
  EXPECT_EQ(distances.at(100, 10), 0.0F);
}

TEST(ScenePlanes, TheNearestOfGroundAndWallsIsTaken) {
  SceneWall ridge, house;
  ridge.distance_m = 3500.0;
  ridge.top_m = 300.0;
  house.distance_m = 200.0;
  house.from = from_degrees(-20.0);
  house.to = from_degrees(-5.0);
  house.top_m = 10.0;
  const auto distances = distances_to({12.0, {ridge, house}}, camera());
  const auto along = [](int x, int y) {
    return std::sqrt(1.0 + (std::pow(x - 100, 2) + std::pow(y - 50, 2)) / (kFocal_px * kFocal_px));
  };
  EXPECT_NEAR(distances.at(100, 45), 3500.0 * along(100, 45), 0.1);
  EXPECT_NEAR(distances.at(20, 45), 200.0 * along(20, 45), 0.01) << "the house, azimuth -16 deg";
  EXPECT_NEAR(distances.at(180, 45), 3500.0 * along(180, 45), 0.1) << "no house to the right";
  // The house's top is 10 m / 200 m of the focal length above the horizon, the ridge at 300 / 3500.
  const int roof = 50 - static_cast<int>(std::ceil(kFocal_px * 10.0 / 200.0));
  EXPECT_NEAR(distances.at(20, roof - 1), 3500.0 * along(20, roof - 1), 0.1);
  const int crest = 50 - static_cast<int>(std::ceil(kFocal_px * 300.0 / 3500.0));
  EXPECT_EQ(distances.at(100, crest - 1), 0.0F);
  EXPECT_LT(distances.at(20, 90), 200.0F) << "the ground in front of the house";
}

TEST(ScenePlanes, AreReadAndAllProblemsAreReported) {
  const auto file = test_output_folder() / "planes.toml";
  ASSERT_TRUE(write_text_file(file, "camera_height_m = 3\n[[walls]]\ndistance_m = 900\nazimuth_deg = 90\n"));
  const auto planes = read_scene_planes(file);
  ASSERT_TRUE(planes) << planes.error().message;
  EXPECT_EQ(planes->camera_height_m, 3.0);
  ASSERT_EQ(planes->walls.size(), 1U);
  EXPECT_NEAR(planes->walls[0].faces.value, 0.5 * kPi, 1e-12);
  EXPECT_TRUE(planes->sky_from_picture());
  ASSERT_TRUE(write_text_file(file, "camera_hight_m = 3\n[[walls]]\ndistance_m = -9\nfrom_deg = 1\n"));
  const auto wrong = read_scene_planes(file);
  ASSERT_FALSE(wrong);
  for (const char* word : {"camera_hight_m", "distance_m = -9", "to_deg"})
    EXPECT_THAT(wrong.error().message, HasSubstr(word));
}

}  // namespace
}  // namespace kasumi
