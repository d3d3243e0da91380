#include "estimator/light/skyline.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "base/sky/sun_disc.hpp"

namespace kasumi {

namespace {

double once_round(double azimuth_deg) {
  const double turned = std::fmod(azimuth_deg, 360.0);
  return turned < 0.0 ? turned + 360.0 : turned;
}

}  // namespace

Skyline::Skyline(std::vector<Point> points) : points_(std::move(points)) {
  for (auto& point : points_) point.azimuth_deg = once_round(point.azimuth_deg);
  std::ranges::sort(points_, {}, &Point::azimuth_deg);
}

double Skyline::elevation_deg(double azimuth_deg) const {
  if (points_.empty()) return 0.0;
  const double at = once_round(azimuth_deg);
  const auto next = std::ranges::upper_bound(points_, at, {}, &Point::azimuth_deg);
  const Point& after = next == points_.end() ? points_.front() : *next;
  const Point& before = next == points_.begin() ? points_.back() : *std::prev(next);
  const double way = once_round(after.azimuth_deg - before.azimuth_deg);
  if (way <= 0.0) return before.elevation_deg;  // the only point
  return std::lerp(before.elevation_deg, after.elevation_deg, once_round(at - before.azimuth_deg) / way);
}

double Skyline::sunlight(const SunDirection& sun) const {
  const double skyline_deg = elevation_deg(to_degrees(azimuth_angle(sun)));
  if (skyline_deg <= 0.0) return 1.0;
  const double above_deg = 90.0 - to_degrees(zenith_angle(sun)) - skyline_deg;
  // A straight edge across the disc.
  const double level = std::clamp(above_deg / to_degrees(kSunRadius), -1.0, 1.0);
  return 0.5 + (level * std::sqrt(1.0 - level * level) + std::asin(level)) / kPi;
}

}  // namespace kasumi
