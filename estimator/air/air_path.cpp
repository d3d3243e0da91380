#include "estimator/air/air_path.hpp"

#include <algorithm>
#include <cmath>

#include "base/sky/sky_text.hpp"
#include "calib/colour/colorimetry.hpp"
#include "estimator/air/attenuation.hpp"

namespace kasumi {
namespace {

// Bodhaine 1999, Eq 30: optical depth of the standard atmosphere from sea level.
double molecular_depth(double wavelength_nm) {
  const double um = 1e-3 * wavelength_nm, s = 1.0 / (um * um);
  return 0.0021520 * (1.0455996 - 341.29061 * s - 0.90230850 / s) / (1.0 + 0.0027059889 * s - 85.968563 / s);
}

// Absorption by 1 cm of ozone (Preetham 1999 table 2, from Iqbal 1983), 10 nm from 450 to 780 nm.
double ozone_per_cm(double wavelength_nm) {
  constexpr double first_nm = 440.0;
  constexpr double table[] = {0.0,   0.003, 0.006, 0.009, 0.014, 0.021, 0.03,  0.04,  0.048, 0.063, 0.075, 0.085,
                              0.103, 0.12,  0.12,  0.115, 0.125, 0.12,  0.105, 0.09,  0.079, 0.067, 0.057, 0.048,
                              0.036, 0.028, 0.023, 0.018, 0.014, 0.011, 0.01,  0.009, 0.007, 0.004, 0.0};
  constexpr int last = std::size(table) - 1;
  const double position = std::clamp((wavelength_nm - first_nm) / 10.0, 0.0, static_cast<double>(last));
  const int left = std::min(static_cast<int>(position), last - 1);
  return std::lerp(table[left], table[left + 1], position - left);
}
constexpr double kOzone_cm = 0.3434;  // U Table 3.1

// Linear sRGB of daylight, every nanometre: what reaches the eye from a grey wall.
SpectralMeasure srgb_measure() {
  const glm::dmat3 to_srgb = xyz_to_linear_srgb();
  SpectralMeasure measure;
  glm::dvec3 sum{0};
  for (double nm = kFirstVisible_nm; nm <= kLastVisible_nm; nm += 1.0) {
    measure.weight.push_back(to_srgb * colour_matching(nm) * daylight_spectrum(0.3127, 0.3290, nm));
    sum += measure.weight.back();
  }
  for (glm::dvec3& weight : measure.weight) weight /= sum;
  return measure;
}

}  // namespace

AirCoefficients air_coefficients(const Aerosol& aerosol) {
  static const AttenuationNodes nodes = attenuation_nodes(srgb_measure());
  AirCoefficients air;
  for (int n = 0; n < kAirNodes; ++n) {
    air.weight[n] = nodes.weight[n];
    for (int c = 0; c < 3; ++c) {
      const double nm = nodes.wavelength_nm[n][c];
      air.molecules_per_m[n][c] = static_cast<float>(molecular_depth(nm) / sky_text::kAirColumn_m);
      air.aerosol_per_m[n][c] = static_cast<float>(optical_depth(aerosol, nm) / kAerosolHeight_m);
      air.ozone[n][c] = static_cast<float>(kOzone_cm * ozone_per_cm(nm));
    }
  }
  return air;
}

}  // namespace kasumi
