#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "base/geometry.hpp"

namespace kasumi {
namespace {

constexpr double kTiny = 1e-12;

TEST(Geometry, ZenithAndAzimuthRoundTrip) {
  for (double zenith = 1; zenith < 180; zenith += 13)
    for (double azimuth = 0; azimuth < 360; azimuth += 17) {
      const auto d = direction_from(from_degrees(zenith), from_degrees(azimuth));
      EXPECT_NEAR(to_degrees(zenith_angle(d)), zenith, 1e-10);
      EXPECT_NEAR(to_degrees(azimuth_angle(d)), azimuth, 1e-10);
    }
}

TEST(Geometry, AzimuthNinetyIsEast) {
  const auto east = direction_from(from_degrees(90), from_degrees(90));
  EXPECT_NEAR(east.x, 1.0, kTiny);
  EXPECT_NEAR(east.y, 0.0, kTiny);
}

TEST(Geometry, AngleBetweenIsExactForTinyAngles) {
  const auto a = direction_from(from_degrees(40), from_degrees(10));
  const auto b = direction_from(from_degrees(40 + 1e-6), from_degrees(10));
  EXPECT_NEAR(to_degrees(angle_between(a, b)), 1e-6, 1e-12);
}

TEST(Geometry, ALevelCameraFacingNorthHasEastOnItsRightAndTheGroundBelow) {
  const auto r = camera_to_world(from_degrees(0), from_degrees(0), from_degrees(0));
  EXPECT_NEAR(glm::length(r * glm::dvec3(1, 0, 0) - glm::dvec3(1, 0, 0)), 0, kTiny);
  EXPECT_NEAR(glm::length(r * glm::dvec3(0, 1, 0) - glm::dvec3(0, 0, -1)), 0, kTiny);
  EXPECT_NEAR(glm::length(r * glm::dvec3(0, 0, 1) - glm::dvec3(0, 1, 0)), 0, kTiny);
}

TEST(Geometry, AnUpwardCameraSeesAzimuthGrowCounterClockwiseFromTheTop) {
  // heading 180: the top of the image is azimuth 0; the left is then east (90 deg).
  const auto r = camera_to_world(from_degrees(180), from_degrees(90), from_degrees(0));
  EXPECT_NEAR(to_degrees(azimuth_angle(r * glm::dvec3(0.001, -1, 0))), 360, 0.1);
  EXPECT_NEAR(to_degrees(azimuth_angle(r * glm::dvec3(-1, 0, 0))), 90, 1e-9);
}

TEST(Geometry, RollTurnsTheCameraClockwiseAsSeenFromBehind) {
  // Turned clockwise, the camera's right side points down and its top to the right.
  const auto r = camera_to_world(from_degrees(0), from_degrees(0), from_degrees(90));
  EXPECT_NEAR((r * glm::dvec3(1, 0, 0)).z, -1, kTiny);
  EXPECT_NEAR((r * glm::dvec3(0, -1, 0)).x, 1, kTiny);
}

}  // namespace
}  // namespace kasumi
