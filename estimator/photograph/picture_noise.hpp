// A photograph without its noise, so that noise need not be taken for light of the scene.
#pragma once

#include <glm/vec3.hpp>

#include "base/image.hpp"

namespace kasumi {

// Standard deviations of an encoded picture's noise in three directions of colour: grey, red to blue, and green to the
// two. By Immerkaer's mask (Fast noise variance estimation, 1996), which takes no notice of slopes, in the smoothest
// tenth of the picture's tiles; clipped pixels are left out. 0: none is seen, as in what was drawn or smoothed.
glm::dvec3 noise_of(const Image<glm::vec3>& encoded);

// Lee 1980: every window of 5 x 5 pixels is brought towards its mean by as much as noise explains of how it varies, in
// each of the three directions by itself. A guess at what lies under the noise, at most as detailed as the picture;
// where noise is 0 it is the picture.
Image<glm::vec3> without_noise(const Image<glm::vec3>& encoded, const glm::dvec3& noise);

}  // namespace kasumi
