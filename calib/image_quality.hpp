// Sharpness, noise and chroma resolution of a camera's pictures, which rendered objects have to match.
#pragma once

#include <optional>

#include "base/table/config_table.hpp"

namespace kasumi {

struct ImageQuality {
  // Standard deviation of the camera's point spread, lens and sensor together (and sharpening, where it is not given by
  // itself), as a Gaussian; the pixel's own area is not included. 0: none.
  double point_spread_px = 0.0;
  // Electrons that full scale stands for at gain 1: 5000 to 50000 in most cameras. 0: the noise is not known.
  double full_scale_electrons = 0.0;
  double read_electrons = 0.0;  // standard deviation, before any gain
  bool shared_chroma = false;   // where the camera delivers one colour for two or four pixels, so does the object
  double sharpening = 0.0;      // amount a: encoded Y + a (Y - its binomial mean over 3 x 3 pixels)
  // calib/colour/camera_saturation. Empty: not known; it is learnt where it can be.
  std::optional<double> saturation{};
  bool jpeg_blocks = false;  // where the camera delivers JPEG, the object is rounded as its blocks are
};

// point_spread_px, sharpening, saturation, shared_chroma, jpeg_blocks and [.noise] of [scene]. Problems are recorded in
// the table.
ImageQuality read_image_quality(const ConfigTable& scene);

}  // namespace kasumi
