#include <cmath>

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "base/sky/light_around.hpp"

namespace kasumi {
namespace {

Direction at_deg(double zenith, double azimuth) {
  return direction_from(from_degrees(zenith), from_degrees(azimuth));
}

TEST(LightAroundMap, RoundTripsForAllDirections) {
  for (double zenith = 0.0; zenith <= 179.9; zenith += 7.3)
    for (double azimuth = 0.0; azimuth < 360.0; azimuth += 31.0) {
      const Direction direction = at_deg(zenith, azimuth);
      EXPECT_LE(angle_between(direction_on_map(place_on_map(direction)), direction).value, 1e-7);
    }
  EXPECT_EQ(place_on_map({0, 0, 1}), glm::dvec2(0.0));
  for (const double azimuth : {0.0, 45.0, 160.0, 290.0}) {
    const glm::dvec2 horizon = place_on_map(at_deg(90.0, azimuth));
    EXPECT_NEAR(std::abs(horizon.x) + std::abs(horizon.y), 1.0, 1e-12);
    EXPECT_NEAR(std::abs(horizon.x / horizon.y), std::abs(std::tan(from_degrees(azimuth).value)), 1e-9);
  }
}

TEST(LightAroundMap, FoldsOntoItselfAtItsEdges) {
  for (const glm::dvec2& place : {glm::dvec2{1.03, 0.4}, {-1.02, 0.0}, {0.7, -1.04}, {1.0, 0.9}}) {
    const bool sideways = std::abs(place.x) >= 1.0;
    const glm::dvec2 same = sideways ? glm::dvec2{std::copysign(2.0, place.x) - place.x, -place.y}
                                     : glm::dvec2{-place.x, std::copysign(2.0, place.y) - place.y};
    EXPECT_LE(angle_between(direction_on_map(place), direction_on_map(same)).value, 1e-9);
    // Crossing the edge is not a jump.
    EXPECT_LE(angle_between(direction_on_map(place), direction_on_map(0.999 * place)).value, 0.01);
  }
}

TEST(LightAroundMap, AUniformSkyGivesPiLFromAboveHalfFromTheSideAndNothingFromBelow) {
  const auto sky = light_around_of([](const Direction& d) { return d.z > 0.0 ? glm::dvec3{1, 2, 3} : glm::dvec3{0}; });
  EXPECT_NEAR(irradiance(sky, {0, 0, 1}).x, kPi, 2e-3);
  EXPECT_NEAR(irradiance(sky, {0, 0, 1}).z, 3.0 * kPi, 6e-3);
  EXPECT_NEAR(irradiance(sky, at_deg(90.0, 77.0)).x, kPi / 2.0, 2e-3);
  EXPECT_NEAR(irradiance(sky, {0, 0, -1}).x, 0.0, 2e-3);
}

TEST(LightAroundMap, UniformSurroundingsLightAllSidesEqually) {
  const auto even = light_around_of([](const Direction&) { return glm::dvec3{1.0}; });
  for (double zenith = 0.0; zenith <= 180.0; zenith += 11.0)
    for (double azimuth = 0.0; azimuth < 360.0; azimuth += 45.0)
      EXPECT_NEAR(irradiance(even, at_deg(zenith, azimuth)).y, kPi, 1e-6);
}

TEST(LightAroundMap, ALinearGradientOfLightFollowsItsClosedForm) {
  // Radiance 1 + a x, x east: irradiance on a normal n is pi + a 2 pi / 3 n.x.
  const auto sky = light_around_of([](const Direction& d) { return glm::dvec3{1.0 + 0.8 * d.x}; });
  for (double zenith = 0.0; zenith <= 180.0; zenith += 20.0)
    for (double azimuth = 0.0; azimuth < 360.0; azimuth += 25.0) {
      const Direction normal = at_deg(zenith, azimuth);
      EXPECT_NEAR(irradiance(sky, normal).x, kPi + 0.8 * 2.0 * kPi / 3.0 * normal.x, 4e-3);
    }
}

}  // namespace
}  // namespace kasumi
