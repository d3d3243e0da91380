// What a wrong spectral sensitivity does to Gamma, the share of light that passes through the air (M Eq 11).
#pragma once

#include <array>
#include <span>
#include <vector>

#include "calib/colour/sensitivity_fit.hpp"
#include "estimator/air/attenuation.hpp"

namespace kasumi {

struct GammaError {
  double largest = 0.0;
  glm::dvec3 by_channel{};               // the largest of each
  std::array<double, 7> by_turbidity{};  // the largest at T = 2, 3, ..., 8
};
// Over T 2 to 8 and level paths to 10 km at sea level, every half kilometre.
GammaError gamma_error(const SpectralSensitivity& assumed, const SpectralSensitivity& truth);

// The error to be expected of fit_sensitivity under these skies: each measured camera in turn is taken out, seen under
// the same skies (with `left` on top, what the sky model was off by) and found from the others. Empty with fewer than
// 3 cameras. One element per camera.
std::vector<GammaError> leave_one_out(std::span<const SkyColour> colours, std::span<const glm::dvec2> left,
                                      std::span<const SpectralSensitivity> cameras);

}  // namespace kasumi
