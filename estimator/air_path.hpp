// What is left of light after a path between any two altitudes up to 100 km: the corrected form of U's transparency
// integral (U Eq 3.2-3.4 gives negative depths; physics 4, docs/sky.md).
#pragma once

#include <glm/vec3.hpp>

#include "base/dome_function.hpp"
#include "estimator/atmosphere.hpp"

namespace kasumi {

// What stands above an altitude, straight up, as length of sea-level air [m], length of sea-level haze [m] and share of
// the ozone layer. US standard atmosphere 1976 (molecules: the pressure), e^{-h / 1200 m}, Green's ozone profile.
struct AirColumns {
  double molecules_m = 0.0;
  double aerosol_m = 0.0;
  double ozone = 0.0;
};
AirColumns columns_above(double altitude_m);

// The same along the straight path of a length between two altitudes. distance_m >= |difference of the altitudes|.
//   s (N(h0) - N(h1)) / (h1 - h0), N = columns_above: exact over a flat earth. The ends are kept 50 m apart, which
//   leaves no 0 / 0 and costs 1e-4 at most. The earth's curvature lets a path sag by up to s^2 / 8R in its middle;
//   each column grows by exp(s^2 / (2 R H) / sqrt(36 + ((h1 - h0) / H)^2)), H its scale height there.
// For paths that do not dip below their lower end by more than H: sights of 200 km, not tangents through the shell.
AirColumns columns_between(double altitude_0_m, double altitude_1_m, double distance_m);

// For light in linear sRGB. Molecules after Bodhaine 1999, aerosol by the dome's own mapping of T (docs/sky.md):
// Angstrom's optical depth (.04608 T - .04586) um^-1.3 over a scale height of 1200 m, ozone of the dome's atmosphere.
AirCoefficients air_coefficients(Turbidity turbidity);

// Per channel, in 0..1.
glm::dvec3 transparency(const AirCoefficients& air, const AirColumns& path);

}  // namespace kasumi
