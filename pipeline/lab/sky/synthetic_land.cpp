#include "pipeline/lab/sky/synthetic_land.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

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
constexpr int kMostPlaces = 6;  // along the strip of land that a pixel sees

// Octaves finer than what a picture resolves there are left out, so that the distance does not flicker.
double resolved(double wavelength_m, double footprint_m) {
  return glm::smoothstep(1.0, 2.5, wavelength_m / std::max(footprint_m, 1e-3));
}
double fractal(std::uint64_t seed, const glm::dvec2& p, double wavelength_m, int octaves, double footprint_m) {
  int seen = 0;
  while (seen < octaves && resolved(wavelength_m * std::pow(0.5, seen), footprint_m) > 0.0) ++seen;
  return fractal(seed, p / wavelength_m, seen);
}

// 0 open .. 1 wood, none around the observer.
double wood_at(const glm::dvec2& p, double footprint_m) {
  const double clearing = 1.0 - glm::smoothstep(250.0, 450.0, glm::length(p));
  return glm::smoothstep(0.13, 0.1308, fractal(kSeed + 60, p, 1700.0, 7, footprint_m) - clearing);
}

constexpr double kTrees_m = 10.0;
// Above the ground, of crowns 9 m wide in groups.
double trees_at(const glm::dvec2& p, double footprint_m) {
  const double wood = wood_at(p, footprint_m);
  if (wood <= 0.0) return 0.0;
  const double crown = 1.0 - std::abs(noise(kSeed + 61, p / 9.0));
  return wood *
         (10.0 + 6.0 * fractal(kSeed + 62, p, 70.0, 3, footprint_m) + 4.0 * resolved(9.0, footprint_m) * (crown - 0.6));
}

// What grows on a parcel: meadow, young and ripe corn, ploughed land, stubble.
struct Parcel {
  glm::dvec3 albedo{0.0};
  glm::dvec2 across{1.0, 0.0};  // its furrows
  double to_border_m = 0.0;
};
constexpr double kParcel_m = 170.0;
Parcel parcel_at(glm::dvec2 p) {
  static const std::array<glm::dvec3, 6> kCrops{{{0.085, 0.135, 0.045},
                                                 {0.105, 0.160, 0.050},
                                                 {0.255, 0.215, 0.110},
                                                 {0.150, 0.120, 0.085},
                                                 {0.210, 0.190, 0.105},
                                                 {0.070, 0.110, 0.040}}};
  // Crooked borders, as land has that was divided by inheritance.
  p += 70.0 * glm::dvec2(noise(kSeed + 90, p / 900.0), noise(kSeed + 91, p / 900.0));
  p = glm::dvec2(0.94 * p.x - 0.34 * p.y, 1.6 * (0.34 * p.x + 0.94 * p.y));
  const glm::dvec2 cell = glm::floor(p / kParcel_m);
  double nearest = 1e18, next = 1e18, chance = 0.0;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) {
      const auto x = static_cast<std::int64_t>(cell.x) + dx, y = static_cast<std::int64_t>(cell.y) + dy;
      const glm::dvec2 middle(static_cast<double>(x) + 0.1 + 0.8 * at_corner(kSeed + 92, x, y),
                              static_cast<double>(y) + 0.1 + 0.8 * at_corner(kSeed + 93, x, y));
      const double off = glm::length(p / kParcel_m - middle);
      if (off < nearest) {
        next = nearest;
        nearest = off;
        chance = at_corner(kSeed + 94, x, y);
      } else {
        next = std::min(next, off);
      }
    }
  const double turned = 40.0 * chance, crops = static_cast<double>(kCrops.size());
  return {kCrops[static_cast<std::size_t>(chance * crops)],
          {std::cos(turned), std::sin(turned)},
          0.5 * kParcel_m * (next - nearest)};
}

// 1 in the hedge around a parcel, in which there are gaps.
constexpr double kHedge_m = 2.5;  // half its width
double hedge_at(const glm::dvec2& p, const Parcel& parcel, double footprint_m) {
  const double width_m = std::max(kHedge_m, 1.5 * footprint_m);
  return std::min(kHedge_m / width_m, 1.0) * (1.0 - glm::smoothstep(0.5 * width_m, width_m, parcel.to_border_m)) *
         glm::smoothstep(-0.3, 0.0, noise(kSeed + 95, p / 40.0));
}

// Fields with their hedges; from afar what they are in the mean.
glm::dvec3 fields_at(const glm::dvec2& p, double footprint_m) {
  const glm::dvec3 mean(0.146, 0.155, 0.073), hedge(0.045, 0.065, 0.03);
  const Parcel parcel = parcel_at(p);
  constexpr double kFurrow_m = 3.5;
  const double furrows =
      resolved(kFurrow_m, footprint_m) * std::sin(2.0 * kPi * glm::dot(p, parcel.across) / kFurrow_m);
  const double uneven = 0.6 * fractal(kSeed + 81, p, 60.0, 7, footprint_m) + 0.08 * furrows;
  const glm::dvec3 seen = glm::mix(parcel.albedo * (1.0 + uneven), hedge, hedge_at(p, parcel, footprint_m));
  return glm::mix(mean, seen, resolved(2.0 * kParcel_m, footprint_m));
}

// Evenly in the picture's rows as far as the plain goes, where mountains may stand evenly in the distance's logarithm.
std::vector<double> rings_of(const LandView& view) {
  std::vector<double> rings;
  const int rows = std::max(8, static_cast<int>(std::lround(view.steepest.value / view.row.value)));
  for (int row = 0; row < rows; ++row) {
    const double r = view.eyes_m / std::tan(view.steepest.value * (1.0 - static_cast<double>(row) / rows));
    if (r > view.nearest_m && r < view.farthest_m) rings.push_back(r);
  }
  const double from = view.mountains ? std::clamp(4000.0, view.nearest_m, view.farthest_m) : view.nearest_m;
  for (int i = 0; i < view.rings; ++i)
    rings.push_back(from * std::pow(view.farthest_m / from, static_cast<double>(i) / (view.rings - 1)));
  rings.push_back(view.nearest_m);
  std::ranges::sort(rings);
  const auto same = [](double a, double b) { return b < 1.0005 * a; };
  rings.erase(std::unique(rings.begin(), rings.end(), same), rings.end());
  return rings;
}

}  // namespace

double synthetic_height_m(const glm::dvec2& p, bool mountains, double footprint_m) {
  const double distance = glm::length(p);
  const double trees = trees_at(p, footprint_m);
  const double hills =
      glm::smoothstep(3e3, 9e3, distance) * 130.0 * std::max(0.0, 0.1 + fractal(kSeed + 25, p, 4.6e3, 6, footprint_m));
  const double plain = 12.0 + 8.0 * fractal(kSeed + 50, p / 1500.0, 4) + hills;
  if (!mountains) return plain + trees;
  const double foothills =
      glm::smoothstep(6e3, 16e3, distance) * 900.0 * std::max(0.0, 0.18 + fractal(kSeed + 20, p, 5e3, 8, footprint_m));
  const double range = glm::smoothstep(17e3, 32e3, distance + 5e3 * noise(kSeed + 40, p / 14e3));
  const double peaks = range > 0.0 ? range * 3700.0 * ridged(kSeed, p / 13e3 + glm::dvec2(3.3, 7.1), 9) : 0.0;
  return plain + foothills + peaks + (1.0 - range) * trees;
}

glm::dvec3 synthetic_albedo(const glm::dvec2& p, double height_m, double steepness, double footprint_m) {
  const double patches = fractal(kSeed + 70, p, 1400.0, 6, footprint_m),
               rough = fractal(kSeed + 80, p, 220.0, 6, footprint_m);
  const glm::dvec3 wood =
      glm::dvec3(0.030, 0.048, 0.020) * (1.0 + 0.5 * rough + 0.5 * fractal(kSeed + 63, p, 18.0, 4, footprint_m));
  const glm::dvec3 rock = glm::dvec3(0.20, 0.18, 0.16) * (1.0 + 0.6 * rough);
  const glm::dvec3 snow(0.80, 0.82, 0.85);
  const double ragged = 260.0 * patches + 90.0 * rough;
  const double wooded = std::max(wood_at(p, footprint_m), glm::smoothstep(60.0, 220.0, height_m + 0.6 * ragged));
  glm::dvec3 albedo = wooded < 1.0 ? glm::mix(fields_at(p, footprint_m), wood, wooded) : wood;
  albedo = glm::mix(albedo, rock, glm::smoothstep(1350.0, 1800.0, height_m + ragged));
  if (height_m > 300.0) albedo = glm::mix(albedo, rock, glm::smoothstep(0.35, 0.6, steepness));
  const double lies = 1.0 - glm::smoothstep(0.28, 0.5, steepness);
  return glm::mix(albedo, snow, lies * glm::smoothstep(1900.0, 2350.0, height_m + ragged));
}

DomeLand make_synthetic_land(const LandView& view) {
  const auto rings = rings_of(view);
  DomeLand land;
  land.columns = view.columns;
  land.rings = static_cast<int>(rings.size());
  land.vertices.reserve(static_cast<std::size_t>(land.columns) * rings.size());
  const double column_rad = (view.to.value - view.from.value) / (view.columns - 1);
  for (std::size_t ring = 0; ring < rings.size(); ++ring) {
    const double r = rings[ring], deep_m = ring + 1 < rings.size() ? rings[ring + 1] - r : r - rings[ring - 1];
    // A pixel sees a strip of land, far longer than wide: the mean of several places along it.
    const double wide_m = r * column_rad, step = std::max(2.0, wide_m);
    const int places = std::clamp(static_cast<int>(std::ceil(deep_m / (wide_m + 1.0))), 1, kMostPlaces);
    const double footprint_m = std::max(wide_m, deep_m / places);
    for (int column = 0; column < view.columns; ++column) {
      const double azimuth = view.from.value + column * column_rad;
      const glm::dvec2 out(std::sin(azimuth), std::cos(azimuth)), p = r * out;
      const auto height_at = [&](const glm::dvec2& at) { return synthetic_height_m(at, view.mountains, wide_m); };
      const double height = height_at(p);
      const double east = (height_at(p + glm::dvec2(step, 0.0)) - height) / step;
      const double north = (height_at(p + glm::dvec2(0.0, step)) - height) / step;
      const glm::dvec3 normal = glm::normalize(glm::dvec3(-east, -north, 1.0));
      // The edge of a wood stands between two rings, and is wood down to its foot.
      const bool before_trees = deep_m < kTrees_m * 5.0 && height_at(p + deep_m * out) - height > 0.3 * kTrees_m;
      const int seen = before_trees ? 1 : places;
      glm::dvec3 albedo(0.0);
      for (int i = 0; i < seen; ++i) {
        const double behind = before_trees ? deep_m : deep_m * ((i + 0.5) / seen - 0.5);
        albedo += synthetic_albedo(p + behind * out, height, before_trees ? 0.0 : 1.0 - normal.z, footprint_m) /
                  static_cast<double>(seen);
      }
      // Earth curvature, in the observer's level frame.
      land.vertices.push_back({glm::vec3(p.x, p.y, height - r * r / (2.0 * kEarthRadius_m)), static_cast<float>(height),
                               glm::vec3(normal), glm::vec3(albedo)});
    }
  }
  return land;
}

}  // namespace kasumi
