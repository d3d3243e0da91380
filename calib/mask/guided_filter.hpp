// He 2013, Guided image filtering: an input smoothed so that it follows the edges of a guide.
#pragma once

#include <glm/vec3.hpp>

#include "base/image.hpp"

namespace kasumi {

// Where the colours of the guide are an affine function of the input within every window, the input is kept. `epsilon`:
// variances of the guide (0..1) below it count as flat. Windows of (2 radius + 1) squared, cut off at the border.
// `step`: that affine function is found in a picture so many times smaller (He and Sun 2015, Fast guided filter).
Image<float> guided_filter(const Image<glm::vec3>& guide, const Image<float>& input, int radius_px, double epsilon,
                           int step = 1);

}  // namespace kasumi
