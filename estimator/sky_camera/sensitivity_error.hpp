// The effect of a wrong spectral sensitivity on Gamma, the transmittance of the air (M Eq 11).
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

// The expected error of fit_sensitivity under these skies: each measured camera in turn is left out, simulated under
// the same skies (plus `left`, the sky model's residuals) and estimated from the others. Empty with fewer than 3
// cameras. One element per camera.
std::vector<GammaError> leave_one_out(std::span<const DaylightColour> colours, std::span<const glm::dvec2> left,
                                      std::span<const SpectralSensitivity> cameras);

}  // namespace kasumi
