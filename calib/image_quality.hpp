// How sharp, how noisy and how finely coloured a camera's pictures are: what is drawn into them should be no better.
#pragma once

#include "base/config_table.hpp"

namespace kasumi {

struct ImageQuality {
  // Standard deviation of the camera's point spread, lens, sensor and sharpening together, as a Gaussian; what a
  // pixel's own square adds is not in it. 0: none.
  double point_spread_px = 0.0;
  // Electrons that full scale stands for at gain 1: 5000 to 50000 in most cameras. 0: the noise is not known.
  double full_scale_electrons = 0.0;
  double read_electrons = 0.0;  // standard deviation, before any gain
  bool shared_chroma = false;   // where the camera delivers one colour for two or four pixels, so does the object
};

// point_spread_px, shared_chroma and [.noise] of [scene]. Problems are left in the table's file.
ImageQuality read_image_quality(const ConfigTable& scene);

}  // namespace kasumi
