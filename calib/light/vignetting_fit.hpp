// Darkening towards the rim, from pictures of something evenly lit.
#pragma once

#include <vector>

#include "base/image.hpp"
#include "base/result.hpp"
#include "calib/light/radiometry.hpp"

namespace kasumi {

struct VignettingFit {
  Vignetting vignetting;
  double residual = 0.0;   // root mean square, relative
  double rim_sigma = 0.0;  // of the illumination at radius_px, relative; one standard deviation
  std::size_t pixels = 0;  // that were used
};

// `light`: linear, any unit, each picture with a gain of its own; pixels that are 0 or under a mask of 0, or farther
// than radius_px from the centre, are ignored. Least squares, pixels beyond 4 robust sigmas dropped (dust, a hand).
// Errors (bad_input): too few pixels; a curve that is not positive out to radius_px.
Result<VignettingFit> fit_vignetting(const std::vector<Image<float>>& light, const Image<std::uint8_t>& mask,
                                     const glm::dvec2& centre, double radius_px);

}  // namespace kasumi
