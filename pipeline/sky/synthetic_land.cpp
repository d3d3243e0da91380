#include "pipeline/sky/synthetic_land.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "base/earth.hpp"

namespace kasumi {
namespace {

double at_corner(std::uint64_t seed, std::int64_t x, std::int64_t y) {  // 0 .. 1 (splitmix64)
  std::uint64_t z =
      seed + 0x9e3779b97f4a7c15u * static_cast<std::uint64_t>(x) + 0xd1b54a32d192ed03u * static_cast<std::uint64_t>(y);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

// Smooth between random corners, -1 .. 1.
double noise(std::uint64_t seed, const glm::dvec2& p) {
  const glm::dvec2 cell = glm::floor(p), t = p - cell;
  const auto ease = [](double u) { return u * u * u * (u * (6.0 * u - 15.0) + 10.0); };
  const auto x = static_cast<std::int64_t>(cell.x), y = static_cast<std::int64_t>(cell.y);
  const double south = std::lerp(at_corner(seed, x, y), at_corner(seed, x + 1, y), ease(t.x));
  const double north = std::lerp(at_corner(seed, x, y + 1), at_corner(seed, x + 1, y + 1), ease(t.x));
  return 2.0 * std::lerp(south, north, ease(t.y)) - 1.0;
}

double fractal(std::uint64_t seed, glm::dvec2 p, int octaves) {
  double sum = 0.0, part = 0.5;
  for (int i = 0; i < octaves; ++i, part *= 0.5) {
    sum += part * noise(seed + static_cast<std::uint64_t>(i), p);
    p = 2.0 * glm::dvec2(0.8 * p.x - 0.6 * p.y, 0.6 * p.x + 0.8 * p.y);  // rotated, to hide the grid
  }
  return sum;
}

// Sharp crests, each octave rough where the one before is high: 0 .. about 1.
double ridged(std::uint64_t seed, glm::dvec2 p, int octaves) {
  double sum = 0.0, part = 0.55, above = 1.0;
  for (int i = 0; i < octaves; ++i, part *= 0.46) {
    const double crest = 1.0 - std::abs(noise(seed + static_cast<std::uint64_t>(i), p));
    above = crest * crest * above;
    sum += part * above;
    above = std::min(1.6 * above, 1.0);
    p = 2.03 * glm::dvec2(0.8 * p.x - 0.6 * p.y, 0.6 * p.x + 0.8 * p.y);
  }
  return sum;
}

constexpr std::uint64_t kSeed = 20050617;

// Of a ring, 0 .. 1: evenly in the distance's logarithm, most of them where mountains may stand.
double distance_of(const LandView& view, double part) {
  constexpr double kPlain_m = 4000.0, kOnPlain = 0.15;
  const double middle = std::clamp(kPlain_m, view.nearest_m, view.farthest_m);
  const auto between = [](double from, double to, double t) { return from * std::pow(to / from, t); };
  return part < kOnPlain ? between(view.nearest_m, middle, part / kOnPlain)
                         : between(middle, view.farthest_m, (part - kOnPlain) / (1.0 - kOnPlain));
}

}  // namespace

double synthetic_height_m(const glm::dvec2& p, bool mountains) {
  const double distance = glm::length(p);
  const double plain = 12.0 + 8.0 * fractal(kSeed + 50, p / 1500.0, 4);
  if (!mountains) return plain;
  const double foothills =
      glm::smoothstep(6e3, 16e3, distance) * 900.0 * std::max(0.0, 0.18 + fractal(kSeed + 20, p / 5e3, 8));
  const double range = glm::smoothstep(17e3, 32e3, distance + 5e3 * noise(kSeed + 40, p / 14e3));
  const double peaks = range * 3700.0 * ridged(kSeed, p / 13e3 + glm::dvec2(3.3, 7.1), 9);
  return plain + foothills + peaks;
}

glm::dvec3 synthetic_albedo(const glm::dvec2& p, double height_m, double steepness) {
  const double patches = fractal(kSeed + 70, p / 1400.0, 6), rough = fractal(kSeed + 80, p / 220.0, 5);
  const glm::dvec3 field = glm::mix(glm::dvec3(0.10, 0.14, 0.05), glm::dvec3(0.24, 0.20, 0.10),
                                    glm::smoothstep(-0.15, 0.25, patches + 0.3 * rough));
  const glm::dvec3 wood = glm::dvec3(0.035, 0.055, 0.025) * (1.0 + 0.5 * rough);
  const glm::dvec3 rock = glm::dvec3(0.20, 0.18, 0.16) * (1.0 + 0.6 * rough);
  const glm::dvec3 snow(0.80, 0.82, 0.85);
  const double ragged = 260.0 * patches + 90.0 * rough;
  glm::dvec3 albedo = glm::mix(field, wood, glm::smoothstep(40.0, 220.0, height_m + 0.6 * ragged));
  albedo = glm::mix(albedo, rock, glm::smoothstep(1350.0, 1800.0, height_m + ragged));
  albedo = glm::mix(albedo, rock, glm::smoothstep(0.35, 0.6, steepness));
  const double lies = 1.0 - glm::smoothstep(0.28, 0.5, steepness);
  return glm::mix(albedo, snow, lies * glm::smoothstep(1900.0, 2350.0, height_m + ragged));
}

DomeLand make_synthetic_land(const LandView& view) {
  DomeLand land;
  land.columns = view.columns;
  land.rings = view.rings;
  land.vertices.reserve(static_cast<std::size_t>(view.columns) * static_cast<std::size_t>(view.rings));
  for (int ring = 0; ring < view.rings; ++ring) {
    const double r = distance_of(view, static_cast<double>(ring) / (view.rings - 1));
    for (int column = 0; column < view.columns; ++column) {
      const double azimuth =
          std::lerp(view.from.value, view.to.value, static_cast<double>(column) / (view.columns - 1));
      const glm::dvec2 p = r * glm::dvec2(std::sin(azimuth), std::cos(azimuth));
      const double height = synthetic_height_m(p, view.mountains), step = std::max(30.0, 0.004 * r);
      const double east = (synthetic_height_m(p + glm::dvec2(step, 0.0), view.mountains) - height) / step;
      const double north = (synthetic_height_m(p + glm::dvec2(0.0, step), view.mountains) - height) / step;
      const glm::dvec3 normal = glm::normalize(glm::dvec3(-east, -north, 1.0));
      // Earth curvature, in the observer's level frame.
      land.vertices.push_back({glm::vec3(p.x, p.y, height - r * r / (2.0 * kEarthRadius_m)), static_cast<float>(height),
                               glm::vec3(normal), glm::vec3(synthetic_albedo(p, height, 1.0 - normal.z))});
    }
  }
  return land;
}

}  // namespace kasumi
