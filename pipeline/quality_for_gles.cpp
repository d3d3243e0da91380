#include "pipeline/quality_for_gles.hpp"

#include <algorithm>
#include <cmath>

namespace kasumi {

ObjectDetail detail_for_gles(const ImageQuality& quality, PixelLayout layout, double haze_blur_px) {
  constexpr double kStep_px = 0.25;
  ObjectDetail detail;
  detail.point_spread_px = quality.point_spread_px;
  if (haze_blur_px > 0.0)
    detail.point_spread_px =
        std::clamp(kStep_px * std::round(std::hypot(quality.point_spread_px, haze_blur_px) / kStep_px),
                   quality.point_spread_px, kWidestPointSpread_px);
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
