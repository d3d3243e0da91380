// What stands around the object and hides the low sun from it: hills, woods, houses.
#pragma once

#include <vector>

#include "base/geometry.hpp"
#include "estimator/atmosphere.hpp"

namespace kasumi {

class Skyline {
 public:
  struct Point {
    double azimuth_deg = 0.0;    // from north clockwise
    double elevation_deg = 0.0;  // above the level, as seen from the object
  };

  Skyline() = default;  // level on all sides
  // Points of different azimuths, in any order.
  explicit Skyline(std::vector<Point> points);

  // Between points it runs straight, and round the circle. Degrees.
  double elevation_deg(double azimuth_deg) const;
  // The share of the sun's disc above it, 0..1. A skyline at or below the level hides nothing: how much of the disc is
  // above the horizon is the sky model's to know.
  double sunlight(const SunDirection& sun) const;

 private:
  std::vector<Point> points_;  // by azimuth, 0..360; empty: level
};

}  // namespace kasumi
