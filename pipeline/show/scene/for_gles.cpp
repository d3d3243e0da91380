#include "pipeline/show/scene/for_gles.hpp"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "estimator/air/scattering.hpp"

namespace kasumi {

Haze haze_for_gles(const HazeCoefficients& haze, double observer_altitude_m, const FogLayer& fog) {
  static_assert(kHazeNodes == kAttenuationNodes);
  return {haze.weight,         haze.rayleigh_per_m,  haze.mie_per_m,      kRayleighScaleHeight_m, kMieScaleHeight_m,
          observer_altitude_m, fog.extinction_per_m, fog.base_altitude_m, fog.scale_height_m};
}

ObjectLight light_for_gles(const LightOnObject& light) {
  return {light.sun_direction, light.sun_irradiance, light.albedo_to_channels, light.around};
}

ResponseCurve response_for_gles(const Response& response) {
  ResponseCurve curve;
  switch (response.kind()) {
    case Response::Kind::linear: curve.kind = ResponseCurve::Kind::linear; return curve;
    case Response::Kind::srgb: curve.kind = ResponseCurve::Kind::srgb; return curve;
    case Response::Kind::table: break;
  }
  curve.kind = ResponseCurve::Kind::table;
  constexpr int kEntries = 1024;  // finer than the steps of 8 bits where the curve is steepest
  for (int i = 0; i < kEntries; ++i) {
    const glm::dvec3 light = response.to_light(glm::dvec3{static_cast<double>(i) / (kEntries - 1)});
    for (int c = 0; c < 3; ++c) curve.light[static_cast<std::size_t>(c)].push_back(light[c]);
  }
  return curve;
}

SceneView view_for_gles(const Camera& scene, const glm::dvec3& object_centre_m, double object_radius_m) {
  const auto pinhole = pinhole_model(*scene.lens).value_or(PinholeParameters{});
  SceneView view;
  view.width = scene.width;
  view.height = scene.height;
  view.focal_px = pinhole.focal_px;
  view.centre_px = pinhole.centre;
  view.distortion = pinhole.distortion;
  view.world_to_camera = glm::dmat4{glm::transpose(scene.to_world)};
  // Planar depth at the picture's edge is well below the range: half the nearest range leaves room.
  const double distance = glm::length(object_centre_m);
  view.near_m = std::max(0.5, 0.5 * (distance - object_radius_m));
  view.far_m = 2.0 * (distance + object_radius_m);
  return view;
}

AirlightGrid airlight_grid(const Camera& scene, const PixelBox& box,
                           const std::function<glm::dvec3(const glm::dvec2&, const Direction&)>& light) {
  AirlightGrid grid;
  grid.first_px = {box.left - 0.5, box.top - 0.5};
  grid.last_px = {box.right - 0.5, box.bottom - 0.5};
  for (int row = 0; row < AirlightGrid::kRows; ++row)
    for (int column = 0; column < AirlightGrid::kColumns; ++column) {
      const glm::dvec2 share{column / (AirlightGrid::kColumns - 1.0), row / (AirlightGrid::kRows - 1.0)};
      const glm::dvec2 pixel = grid.first_px + share * (grid.last_px - grid.first_px);
      const auto direction = scene.direction_at(pixel).value_or(scene.to_world * glm::dvec3{0, 0, 1});
      grid.light[static_cast<std::size_t>(row * AirlightGrid::kColumns + column)] = light(pixel, direction);
    }
  return grid;
}

ObjectDetail detail_for_gles(const ImageQuality& quality, PixelLayout layout, double haze_blur_px) {
  // A kernel's programs are compiled anew for each width: fewer widths, fewer stutters.
  constexpr double kStep_px = 0.25;
  ObjectDetail detail;
  detail.point_spread_px = quality.point_spread_px;
  if (haze_blur_px > 0.0)
    detail.point_spread_px =
        std::clamp(kStep_px * std::round(std::hypot(quality.point_spread_px, haze_blur_px) / kStep_px),
                   quality.point_spread_px, kWidestPointSpread_px);
  detail.sharpening = quality.sharpening;
  detail.jpeg_blocks = quality.jpeg_blocks;
  if (!quality.shared_chroma) return detail;
  switch (layout) {
    case PixelLayout::nv12:
    case PixelLayout::i420: detail.chroma_rows = 2; [[fallthrough]];
    case PixelLayout::yuyv:
    case PixelLayout::uyvy:
    case PixelLayout::i422: detail.chroma_columns = 2; break;
    case PixelLayout::rgb8:
    case PixelLayout::bgr8:
    case PixelLayout::rgba8:
    case PixelLayout::bgra8:
    case PixelLayout::grey8:
    case PixelLayout::i444: break;
  }
  return detail;
}

SensorNoise noise_for_gles(const ImageQuality& quality, const glm::dvec3& white_balance, double gain,
                           std::uint32_t frame) {
  if (quality.full_scale_electrons <= 0.0) return {};
  const glm::dvec3 per_electron = gain * white_balance / quality.full_scale_electrons;
  return {per_electron, per_electron * quality.read_electrons, frame};
}

Image<float> depth_for_gles(const Camera& scene, const Image<float>& distances_m) {
  Image<float> depths = distances_m;
  for (int y = 0; y < depths.height(); ++y)
    for (int x = 0; x < depths.width(); ++x) {
      const auto ray = scene.lens->unproject({x, y});
      depths.at(x, y) *= ray ? static_cast<float>(ray->z) : 0.0f;
    }
  return depths;
}

}  // namespace kasumi
