// Denoising of photographs, so that noise is not mistaken for light of the scene.
#pragma once

#include <glm/vec3.hpp>

#include "base/image.hpp"

namespace kasumi {

// Standard deviations of an encoded picture's noise in three colour directions: grey, red-blue, and green against both.
// By Immerkaer's mask (Fast noise variance estimation, 1996), which ignores slopes, in the smoothest tenth of the
// picture's tiles; clipped pixels are left out. 0: no noise found, as in rendered or smoothed pictures.
glm::dvec3 noise_of(const Image<glm::vec3>& encoded);

// Lee filter (1980): every window of 5 x 5 pixels is moved towards its mean in proportion to the noise's share of its
// variance, separately in each of the three directions. An estimate of the noise-free picture, never with more detail
// than the original; where noise is 0 it is the original.
Image<glm::vec3> without_noise(const Image<glm::vec3>& encoded, const glm::dvec3& noise);

}  // namespace kasumi
