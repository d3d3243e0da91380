// Hills before the sun, against counted points of its disc.
#include <cmath>

#include <gtest/gtest.h>

#include "estimator/light/skyline.hpp"

namespace kasumi {
namespace {

constexpr double kRadius_deg = 0.2666;  // the sun's at the mean distance: 959.63"

SunDirection sun_at(double azimuth_deg, double elevation_deg) {
  return direction_from(from_degrees(90.0 - elevation_deg), from_degrees(azimuth_deg));
}

// Of points evenly over the disc, those above an edge that lies `edge` radii above its middle.
double counted_above(double edge) {
  constexpr int kSteps = 1000;
  int above = 0, all = 0;
  for (int i = 0; i < kSteps; ++i)
    for (int j = 0; j < kSteps; ++j) {
      const double x = (2.0 * i + 1.0) / kSteps - 1.0, y = (2.0 * j + 1.0) / kSteps - 1.0;
      if (x * x + y * y > 1.0) continue;
      ++all;
      above += y > edge;
    }
  return static_cast<double>(above) / all;
}

TEST(Skyline, HidesAsMuchOfTheDiscAsLiesBelowIt) {
  const Skyline wall({{0.0, 12.0}, {180.0, 12.0}});
  for (const double radii : {-1.5, -0.8, -0.3, 0.0, 0.4, 0.9, 1.2})
    EXPECT_NEAR(wall.sunlight(sun_at(250.0, 12.0 + radii * kRadius_deg)), counted_above(-radii), 2e-3) << radii;
}

TEST(Skyline, RunsStraightBetweenItsPointsAndRoundTheCircle) {
  const Skyline valley({{350.0, 10.0}, {90.0, 2.0}, {10.0, 20.0}, {-160.0, 6.0}});
  EXPECT_NEAR(valley.elevation_deg(0.0), 15.0, 1e-9);
  EXPECT_NEAR(valley.elevation_deg(360.0), 15.0, 1e-9);
  EXPECT_NEAR(valley.elevation_deg(-5.0), 12.5, 1e-9);
  EXPECT_NEAR(valley.elevation_deg(50.0), 11.0, 1e-9);
  EXPECT_NEAR(valley.elevation_deg(145.0), 4.0, 1e-9);
  EXPECT_NEAR(valley.elevation_deg(275.0), 8.0, 1e-9);
}

TEST(Skyline, LeavesTheLevelHorizonToTheSky) {
  const Skyline level({{0.0, 0.0}, {120.0, -0.5}, {240.0, -0.2}});
  for (const double elevation_deg : {-1.0, 0.0, 0.1, 30.0}) {
    EXPECT_EQ(level.sunlight(sun_at(200.0, elevation_deg)), 1.0);
    EXPECT_EQ(Skyline{}.sunlight(sun_at(200.0, elevation_deg)), 1.0);
  }
}

}  // namespace
}  // namespace kasumi
