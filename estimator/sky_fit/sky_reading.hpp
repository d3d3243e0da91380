// Light from one direction of the clear sky, as a camera or a sky scanner reads it.
#pragma once

#include <glm/vec3.hpp>

#include "base/geometry.hpp"

namespace kasumi {

struct SkyReading {
  Direction direction{0.0, 0.0, 1.0};  // world frame
  glm::dvec3 light{0.0};               // linear sRGB, any unit, above 0; of a luminance alone all three are the same
  glm::dvec3 sigma{0.0};               // relative standard deviations, by noise and quantisation alone
  double off_axis = 0.0;               // from the optical axis, 1 at the lens' edge; vignetting grows with its square
};

}  // namespace kasumi
