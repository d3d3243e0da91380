#include "calib/colour/spectral_sensitivity.hpp"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>

namespace kasumi {

glm::dvec3 SpectralSensitivity::at(double wavelength_nm) const {
  if (samples.empty() || !(wavelength_nm >= first_nm && wavelength_nm <= last_nm())) return glm::dvec3{0.0};
  const double position = (wavelength_nm - first_nm) / step_nm;
  const auto below = std::min(static_cast<std::size_t>(position), samples.size() - 1);
  const auto above = std::min(below + 1, samples.size() - 1);
  return glm::mix(samples[below], samples[above], position - static_cast<double>(below));
}

SpectralSensitivity generic_sensitivity() {
  const glm::dvec3 peaks_nm{600.0, 540.0, 450.0};
  const glm::dvec3 widths_nm{35.0, 40.0, 30.0};  // standard deviations, as wide as common colour filters
  SpectralSensitivity generic{"generic", 380.0, 5.0, {}};
  for (double nm = 380.0; nm <= 780.0; nm += 5.0) {
    const glm::dvec3 off = (nm - peaks_nm) / widths_nm;
    generic.samples.push_back(glm::exp(-0.5 * off * off));
  }
  return generic;
}

}  // namespace kasumi
