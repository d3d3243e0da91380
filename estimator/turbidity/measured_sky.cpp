#include "estimator/turbidity/measured_sky.hpp"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "base/saturation.hpp"

namespace kasumi {
namespace {

constexpr double kRingWidth = 0.5 * kPi / MeasuredSky::kRings;      // even in zenith angle, [rad]
constexpr double kSectorWidth = 2.0 * kPi / MeasuredSky::kSectors;  // [rad]
// Of the hemisphere.
constexpr std::size_t kCells = static_cast<std::size_t>(MeasuredSky::kRings) * MeasuredSky::kSectors;
constexpr auto kClipped = static_cast<float>(kSaturatedSky);  // one threshold for all of Kasumi
constexpr int kStride = 2;  // every other element in both directions is enough for a cell

std::size_t index_of(int ring, int sector) {
  return static_cast<std::size_t>(ring) * MeasuredSky::kSectors + static_cast<std::size_t>(sector);
}

std::size_t index_of(const Direction& direction) {
  const int ring = static_cast<int>(zenith_angle(direction).value / kRingWidth);
  const int sector = static_cast<int>(azimuth_angle(direction).value / kSectorWidth);
  return index_of(std::clamp(ring, 0, MeasuredSky::kRings - 1), std::clamp(sector, 0, MeasuredSky::kSectors - 1));
}

double solid_angle_of_ring(int ring) {
  return kSectorWidth * (std::cos(ring * kRingWidth) - std::cos((ring + 1) * kRingWidth));
}

// Solid angles within a small round part of the picture. What is too bright near the sun is classified neither as
// cloud nor as clear.
struct Patch {
  double open = 0.0, judged = 0.0, cloud = 0.0;
  double saturated = 0.0, coloured = 0.0;  // in all channels; in any
};
Patch patch_at(const SkyPicture& picture, const ElementGeometry& geometry, const Image<PixelUse>& use,
               const Direction& centre, Radians radius) {
  const auto least = static_cast<float>(std::cos(radius.value));
  const glm::vec3 towards(centre);
  Patch patch;
  for (int y = 0; y < use.height(); ++y)
    for (int x = 0; x < use.width(); ++x) {
      if (geometry.open.at(x, y) == 0 || glm::dot(geometry.direction.at(x, y), towards) < least) continue;
      const auto angle = static_cast<double>(geometry.solid_angle.at(x, y));
      const glm::vec3& encoded = picture.encoded.at(x, y);
      patch.open += angle;
      if (std::min({encoded.r, encoded.g, encoded.b}) >= kClipped) patch.saturated += angle;
      if (std::max({encoded.r, encoded.g, encoded.b}) >= kClipped) patch.coloured += angle;
      const PixelUse as = use.at(x, y);
      if (as == PixelUse::near_sun || as == PixelUse::outside || as == PixelUse::saturated) continue;
      patch.judged += angle;
      if (as != PixelUse::clear) patch.cloud += angle;
    }
  return patch;
}

double smooth_step(double from, double to, double value) {
  const double t = std::clamp((value - from) / (to - from), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

// The sun's disc exceeds a camera's range even through thin cloud, so its core is either saturated or hidden. Near
// clouds, whose bright edges saturate too, the glare that the lens spreads around a high sun is needed to be sure. In a
// clear sky the disc's own few pixels are enough, and for a low sun its red ones: its glare saturates nothing.
double share_by_disc(const Patch& core, const Patch& around) {
  if (core.open <= 0.0) return 1.0;
  const double by_glare = smooth_step(0.15, 0.6, core.saturated / core.open);
  if (around.judged <= 0.0 || around.cloud > 0.05 * around.judged) return by_glare;
  constexpr double kDisc_sr = 6.8e-5;  // pi (.267 deg)^2
  return std::max(by_glare, smooth_step(0.25, 0.75, core.coloured / kDisc_sr));
}

}  // namespace

const MeasuredCell& MeasuredSky::at(const Direction& direction) const {
  return cells[index_of(direction)];
}

Direction MeasuredSky::centre_of(int ring, int sector) {
  return direction_from({(ring + 0.5) * kRingWidth}, {(sector + 0.5) * kSectorWidth});
}

Direction towards_shading_cloud(const glm::dvec3& object_m, const SunDirection& sun, double cloud_base_m) {
  const double climb = cloud_base_m - object_m.z;
  if (sun.z < 0.02 || climb <= 0.0) return sun;
  return glm::normalize(object_m + climb / sun.z * sun);
}

MeasuredSky measure_sky(const SkyPicture& picture, const ElementGeometry& geometry, const Camera& camera,
                        const Image<PixelUse>& use, SkyCondition condition, const SunDirection& sun,
                        const Direction& through, double uncovered_sun) {
  MeasuredSky sky;
  const Patch core = patch_at(picture, geometry, use, sun, from_degrees(1.2));
  const Patch around = patch_at(picture, geometry, use, sun, from_degrees(25.0));
  const double by_disc =
      condition == SkyCondition::overcast ? 0.0 : std::max(uncovered_sun, share_by_disc(core, around));
  sky.sun_share = by_disc;
  if (condition != SkyCondition::overcast && angle_between(through, sun) > from_degrees(4.0)) {
    const Patch shading = patch_at(picture, geometry, use, through, from_degrees(2.0));
    if (shading.judged > 0.3 * shading.open && shading.judged > 0.0)
      sky.sun_share = 1.0 - shading.cloud / shading.judged;
  }

  std::array<double, kCells> open{}, judged{}, clear{};
  std::array<int, kCells> looked{}, free{};
  for (int y = 0; y < use.height(); y += kStride)
    for (int x = 0; x < use.width(); x += kStride) {
      const glm::dvec3 direction(geometry.direction.at(x, y));
      if (direction.z <= 0.0) continue;
      const std::size_t i = index_of(direction);
      ++looked[i];
      if (geometry.open.at(x, y) == 0) continue;
      ++free[i];
      const glm::vec3& encoded = picture.encoded.at(x, y);
      const double angle = kStride * kStride * static_cast<double>(geometry.solid_angle.at(x, y));
      const glm::dvec3 light = camera.response.to_light(glm::dvec3(encoded)) * glm::dvec3(geometry.gain.at(x, y));
      sky.cells[i].xyz += angle * (geometry.light_to_xyz * light);
      sky.cells[i].clipped = sky.cells[i].clipped || std::max({encoded.r, encoded.g, encoded.b}) >= kClipped;
      open[i] += angle;
      const PixelUse as = use.at(x, y);
      if (as == PixelUse::outside) continue;
      judged[i] += angle;
      if (as == PixelUse::clear) clear[i] += angle;
      if (as == PixelUse::near_sun) clear[i] += by_disc * angle;
    }
  for (int ring = 0; ring < MeasuredSky::kRings; ++ring)
    for (int sector = 0; sector < MeasuredSky::kSectors; ++sector) {
      const std::size_t i = index_of(ring, sector);
      MeasuredCell& cell = sky.cells[i];
      if (open[i] > 0.0) cell.xyz /= open[i];
      if (looked[i] > 0) cell.seen = static_cast<double>(free[i]) / looked[i];
      // In cells too low to be classified, clouds are assumed as just above.
      if (judged[i] > 0.2 * open[i] && judged[i] > 0.0)
        cell.clear = clear[i] / judged[i];
      else if (ring > 0)
        cell.clear = sky.cells[index_of(ring - 1, sector)].clear;
    }
  return sky;
}

double difference(const MeasuredSky& a, const MeasuredSky& b) {
  double largest = std::abs(a.sun_share - b.sun_share);
  // Compared by quarters, since light from one side is what changes a building.
  constexpr int kQuarter = MeasuredSky::kSectors / 4;
  for (int quarter = 0; quarter < 4; ++quarter) {
    double cloudy_a = 0.0, cloudy_b = 0.0;
    for (int ring = 0; ring < MeasuredSky::kRings; ++ring)
      for (int sector = quarter * kQuarter; sector < (quarter + 1) * kQuarter; ++sector) {
        const double weight = std::cos((ring + 0.5) * kRingWidth) * solid_angle_of_ring(ring) * 4.0 / kPi;
        cloudy_a += weight * a.cells[index_of(ring, sector)].seen * (1.0 - a.cells[index_of(ring, sector)].clear);
        cloudy_b += weight * b.cells[index_of(ring, sector)].seen * (1.0 - b.cells[index_of(ring, sector)].clear);
      }
    largest = std::max(largest, std::abs(cloudy_a - cloudy_b));
  }
  return largest;
}

}  // namespace kasumi
