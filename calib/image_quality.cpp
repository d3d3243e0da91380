#include "calib/image_quality.hpp"

#include "calib/colour/camera_saturation.hpp"

namespace kasumi {

ImageQuality read_image_quality(const ConfigTable& scene) {
  constexpr Range kSpread_px{0.0, 3.0}, kSharpening{0.0, 3.0}, kElectrons{0.0, 1e7};
  ImageQuality quality;
  quality.point_spread_px = scene.number("point_spread_px", kSpread_px, quality.point_spread_px);
  quality.shared_chroma = scene.flag("shared_chroma", quality.shared_chroma);
  quality.sharpening = scene.number("sharpening", kSharpening, quality.sharpening);
  if (scene.has("saturation")) quality.saturation = scene.number("saturation", {kLeastSaturation, kMostSaturation});
  quality.jpeg_blocks = scene.flag("jpeg_blocks", quality.jpeg_blocks);
  const auto noise = scene.optional_table("noise");
  if (!noise) return quality;
  quality.full_scale_electrons = noise->number("full_scale_electrons", kElectrons, quality.full_scale_electrons);
  quality.read_electrons = noise->number("read_electrons", kElectrons, quality.read_electrons);
  if (quality.read_electrons > 0.0 && quality.full_scale_electrons == 0.0)
    noise->problem("full_scale_electrons", "a number > 0 together with read_electrons, which are counted in its unit");
  return quality;
}

}  // namespace kasumi
