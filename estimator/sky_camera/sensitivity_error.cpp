#include "estimator/sky_camera/sensitivity_error.hpp"

#include <algorithm>
#include <cmath>

namespace kasumi {

GammaError gamma_error(const SpectralSensitivity& assumed, const SpectralSensitivity& truth) {
  constexpr double kFarthest_m = 10e3, kStep_m = 500.0;  // the distances at which buildings are shown
  const auto a = spectral_measure(assumed), b = spectral_measure(truth);
  GammaError error;
  for (std::size_t i = 0; i < error.by_turbidity.size(); ++i)
    for (double s = kStep_m; s <= kFarthest_m; s += kStep_m) {
      const auto path = optical_path(0.0, 0.0, s);
      const Turbidity turbidity{2.0 + static_cast<double>(i)};
      const auto off = glm::abs(attenuation_reference(a, ScatteringModel::morales2017, turbidity, path) -
                                attenuation_reference(b, ScatteringModel::morales2017, turbidity, path));
      error.by_channel = glm::max(error.by_channel, off);
      error.by_turbidity[i] = std::max({error.by_turbidity[i], off.r, off.g, off.b});
      error.largest = std::max(error.largest, error.by_turbidity[i]);
    }
  return error;
}

std::vector<GammaError> leave_one_out(std::span<const DaylightColour> colours, std::span<const glm::dvec2> left,
                                      std::span<const SpectralSensitivity> cameras) {
  std::vector<GammaError> errors;
  if (cameras.size() < 3) return errors;
  for (std::size_t out = 0; out < cameras.size(); ++out) {
    std::vector<SpectralSensitivity> others;
    for (std::size_t i = 0; i < cameras.size(); ++i)
      if (i != out) others.push_back(cameras[i]);
    const auto fit = fit_sensitivity(seen_by(cameras[out], colours, left), others);
    if (fit) errors.push_back(gamma_error(fit->sensitivity, cameras[out]));
  }
  return errors;
}

}  // namespace kasumi
