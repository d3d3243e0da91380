// By how much a camera exaggerates colours, found from haze: contrasts of landmarks fade with distance faster at short
// wavelengths, by as much as aerosols allow; anything beyond is the camera's.
#pragma once

#include <cstddef>
#include <vector>

#include <glm/vec3.hpp>

namespace kasumi {

// Of a contrast's differences from its grey; in light, calib/colour/camera_saturation.
struct ContrastChroma {
  double chroma = 1.0;       // the likeliest; 1: none, or not known
  double log_sigma = 0.0;    // one standard deviation of its logarithm; 0: not known
  std::size_t pictures = 0;  // that could be used
  bool known() const { return log_sigma > 0.0; }
};

// `per_m`: extinction in each of many pictures by each channel alone; `wavelength_nm` of the channels; `path_m` to the
// middle landmark. So that the aerosols of all pictures have, in the middle, the exponent that aerosols have (1.3 +-
// .35). Not known by fewer than 12 pictures with enough haze, and not too much.
ContrastChroma contrast_chroma(const std::vector<glm::dvec3>& per_m, const glm::dvec3& wavelength_nm, double altitude_m,
                               double path_m);

// Before anything is known half of all cameras show colours as they are, the others exaggerate them by 1 +- .4 (of the
// logarithm). What to draw by: the mean of both, each as likely as the landmarks make it. It is exactly 1 where that is
// within a hundredth of it.
double saturation_believed(const ContrastChroma& learnt);

}  // namespace kasumi
