// The horizon's light in the scene camera's picture.
#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "estimator/horizon/horizon.hpp"
#include "estimator/horizon/strips.hpp"

namespace kasumi {
// Every 8th pixel decides for its block.
Image<std::uint8_t> below_horizon(const Camera& camera) {
  constexpr int kBlock = 8;  // chosen: the mask is uncertain by the mounting's error anyway, some pixels
  constexpr double kBelow = 0.5 * kPi / 180.0;  // as far as a camera may be mounted off level, [rad]
  Image<std::uint8_t> mask(camera.width, camera.height);
  for (int y0 = 0; y0 < camera.height; y0 += kBlock) {
    for (int x0 = 0; x0 < camera.width; x0 += kBlock) {
      const int x1 = std::min(x0 + kBlock, camera.width), y1 = std::min(y0 + kBlock, camera.height);
      const auto direction = camera.direction_at({0.5 * (x0 + x1 - 1), 0.5 * (y0 + y1 - 1)});
      if (direction && zenith_angle(*direction).value <= kPi / 2.0 + kBelow) continue;
      for (int y = y0; y < y1; ++y) std::fill(mask.row(y) + x0, mask.row(y) + x1, std::uint8_t{255});
    }
  }
  return mask;
}

HorizonLight measure_horizon(const Camera& scene, const PictureView& picture, int columns) {
  HorizonLight horizon;
  if (picture.width != scene.width || picture.height != scene.height) {
    horizon.reason = fmt::format("picture is {}x{}, the scene camera {}x{}", picture.width, picture.height, scene.width,
                                 scene.height);
    return horizon;
  }
  const Image<Rgb8> rgb = to_rgb(picture);
  const SkySegmentation segmentation = segment_sky(rgb, below_horizon(scene));
  if (!segmentation.visible) {
    horizon.reason = segmentation.reason;
    return horizon;
  }
  const HorizonPixels sky{scene, rgb, segmentation.sky};
  const int wanted = std::clamp(columns, 1, std::max(1, scene.width / 8));
  const std::vector<HorizonStrip> strips = sky_strips(sky, wanted);
  if (4 * static_cast<int>(strips.size()) >= wanted) horizon.columns = clear_sky(sky, strips);
  if (!horizon.columns.empty()) {
    horizon.source = HorizonLight::Source::scene_camera;
    return horizon;
  }
  SmoothHorizon lowest = lowest_sky(sky, strips);
  const int found = static_cast<int>(lowest.columns.size());
  if (4 * found < wanted) {
    horizon.reason = fmt::format("no horizon: sky in {} of {} columns, less than a quarter", found, wanted);
    return horizon;
  }
  horizon.source = HorizonLight::Source::scene_camera;
  horizon.columns = std::move(lowest.columns);
  horizon.reason = lowest.clipped ? "the horizon sky is clipped: its light is a lower bound"
                                  : "little clear sky at the horizon: the lowest sky is used, including clouds";
  return horizon;
}

}  // namespace kasumi
