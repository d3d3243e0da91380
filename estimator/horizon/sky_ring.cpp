// The horizon from the sky camera, or from the sky model, for scenes without sky.
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/matrix.hpp>

#include "base/saturation.hpp"
#include "base/statistics.hpp"
#include "estimator/horizon/horizon.hpp"

namespace kasumi {
namespace {

// As near to the horizon as trees and houses around a sky camera allow.
constexpr double kRingTop_deg = 75.0;
constexpr double kRingBottom_deg = 85.0;

struct RingSample {
  glm::dvec3 light{0};
  double luminance = 0.0;
};

// XYZ of the ring around one azimuth: the sample of median luminance, so that clouds and masts have no influence.
std::optional<RingSample> ring_at(const Camera& sky, const PictureView& picture, const glm::dmat3& to_xyz,
                                  double azimuth, double half_width) {
  std::vector<RingSample> seen;
  // Steps of a degree; enough that a cloud or a mast does not hold the median.
  constexpr int kZeniths = 11, kAzimuths = 9;
  for (int i = 0; i < kZeniths; ++i) {
    for (int j = 0; j < kAzimuths; ++j) {
      const Radians zenith = from_degrees(std::lerp(kRingTop_deg, kRingBottom_deg, i / (kZeniths - 1.0)));
      const auto pixel =
          sky.pixel_of(direction_from(zenith, {azimuth + half_width * (2.0 * j / (kAzimuths - 1.0) - 1.0)}));
      if (!pixel) continue;
      const int x = static_cast<int>(std::lround(pixel->x)), y = static_cast<int>(std::lround(pixel->y));
      if (x < 0 || y < 0 || x >= picture.width || y >= picture.height) continue;
      if (!sky.mask.empty() && sky.mask.at(x, y) == 0) continue;
      const Rgb8 encoded = rgb_at(picture, x, y);
      if (encoded.x >= kSaturatedHorizon || encoded.y >= kSaturatedHorizon || encoded.z >= kSaturatedHorizon) continue;
      const glm::dvec3 xyz = to_xyz * sky.light_at({x, y}, glm::dvec3(encoded) / 255.0);
      if (xyz.y > 0.0) seen.push_back({xyz, xyz.y});
    }
  }
  if (seen.size() < 8) return std::nullopt;
  return quantile(std::move(seen), 0.5, &RingSample::luminance);
}

// Luminance of the brightest objects near the scene's horizon line, or near the picture's top if that lies outside: the
// 98th percentile of what is not clipped, on a coarse grid.
double brightest_distant(const Camera& scene, const PictureView& picture, const glm::dmat3& to_xyz) {
  std::vector<RingSample> near_horizon, anywhere;
  const int step = std::max(1, picture.width / 240);
  for (int y = 0; y < picture.height; y += step) {
    for (int x = 0; x < picture.width; x += step) {
      const Rgb8 encoded = rgb_at(picture, x, y);
      if (encoded.x >= kSaturatedHorizon || encoded.y >= kSaturatedHorizon || encoded.z >= kSaturatedHorizon) continue;
      const double luminance = (to_xyz * scene.light_at({x, y}, glm::dvec3(encoded) / 255.0)).y;
      if (y < picture.height / 5) anywhere.push_back({{}, luminance});
      const auto direction = scene.direction_at({x, y});
      if (direction && std::abs(to_degrees(zenith_angle(*direction)) - 90.0) < 3.0)
        near_horizon.push_back({{}, luminance});
    }
  }
  const auto& chosen = near_horizon.size() >= 50 ? near_horizon : anywhere;
  return quantile(chosen, 0.98, &RingSample::luminance).luminance;
}

// Columns across the scene's view, with the ring's XYZ in the scene camera's channels as light; a column is left out
// where `ring` has no value. `luminance`: their mean.
struct Ring {
  std::vector<HorizonColumn> columns;
  double luminance = 0.0;
};
template <typename RingAt>
Ring ring_across(const Camera& scene, const glm::dmat3& xyz_to_scene, int columns, const RingAt& ring) {
  Ring found;
  const Radians zenith{from_degrees(0.5 * (kRingTop_deg + kRingBottom_deg))};
  for (int i = 0; i < columns; ++i) {
    const auto view = scene.direction_at({(i + 0.5) * scene.width / columns - 0.5, 0.5 * (scene.height - 1)});
    if (!view) continue;
    const Radians azimuth = azimuth_angle(*view);
    const std::optional<RingSample> seen = ring(azimuth);
    if (!seen) continue;
    found.columns.push_back({azimuth, zenith, glm::max(xyz_to_scene * seen->light, glm::dvec3{0.0}), 0.6});
    found.luminance += seen->luminance;
  }
  if (!found.columns.empty()) found.luminance /= static_cast<double>(found.columns.size());
  return found;
}

}  // namespace

HorizonLight horizon_from_model(const std::function<glm::dvec3(const Direction&)>& sky_xyz, const Camera& scene,
                                const PictureView& scene_picture, int columns) {
  HorizonLight horizon;
  if (scene_picture.width != scene.width || scene_picture.height != scene.height) {
    horizon.reason = "the picture's size differs from its camera's";
    return horizon;
  }
  const glm::dmat3 scene_to_xyz = scene.light_to_xyz();
  const double distant = brightest_distant(scene, scene_picture, scene_to_xyz);
  const Radians zenith{from_degrees(0.5 * (kRingTop_deg + kRingBottom_deg))};
  auto ring = ring_across(scene, glm::inverse(scene_to_xyz), std::clamp(columns, 1, std::max(1, scene.width / 8)),
                          [&](Radians azimuth) -> std::optional<RingSample> {
                            const glm::dvec3 xyz = sky_xyz(direction_from(zenith, azimuth));
                            return xyz.y > 0.0 ? std::optional(RingSample{xyz, xyz.y}) : std::nullopt;
                          });
  if (!(distant > 0.0) || ring.columns.empty()) {
    horizon.reason =
        "no horizon: no camera shows sky, and nothing in the scene is bright enough to set the model's level";
    return horizon;
  }
  horizon.columns = std::move(ring.columns);
  for (HorizonColumn& column : horizon.columns) {
    column.quality = 0.15;
    column.light *= distant / ring.luminance;
  }
  horizon.reason =
      "no camera shows sky: colour from the sky model, level assumed from the scene's brightest distant pixels";
  horizon.source = HorizonLight::Source::model;
  return horizon;
}

HorizonLight horizon_from_sky_camera(const Camera& sky, const PictureView& sky_picture, const Camera& scene,
                                     const PictureView& scene_picture, int columns) {
  HorizonLight horizon;
  if (sky_picture.width != sky.width || sky_picture.height != sky.height || scene_picture.width != scene.width ||
      scene_picture.height != scene.height) {
    horizon.reason = "a picture's size differs from its camera's";
    return horizon;
  }
  const glm::dmat3 sky_to_xyz = sky.light_to_xyz();
  const glm::dmat3 scene_to_xyz = scene.light_to_xyz();
  const glm::dmat3 xyz_to_scene = glm::inverse(scene_to_xyz);
  const double half_width = from_degrees(3.0).value;
  auto ring =
      ring_across(scene, xyz_to_scene, std::clamp(columns, 1, std::max(1, scene.width / 8)),
                  [&](Radians azimuth) { return ring_at(sky, sky_picture, sky_to_xyz, azimuth.value, half_width); });
  horizon.columns = std::move(ring.columns);
  if (horizon.columns.empty()) {
    horizon.reason = "no horizon: the sky camera's ring at 75-85 deg is masked, clipped or outside its picture";
    return horizon;
  }

  const double distant = brightest_distant(scene, scene_picture, scene_to_xyz);
  if (!(distant > 0.0)) {
    horizon.columns.clear();
    horizon.reason =
        "no horizon: the scene shows no sky, and nothing in it is bright enough to set the sky camera's level";
    return horizon;
  }
  for (HorizonColumn& column : horizon.columns) {
    column.quality = 0.3;
    column.light *= distant / ring.luminance;
  }
  horizon.reason = "colour from the sky camera; level assumed from the scene's brightest distant pixels";
  horizon.source = HorizonLight::Source::sky_camera;
  return horizon;
}

}  // namespace kasumi
