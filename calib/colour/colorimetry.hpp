// The CIE's tables that connect spectra with colours, and sRGB's with XYZ.
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

namespace kasumi {

constexpr double kFirstVisible_nm = 380.0;
constexpr double kLastVisible_nm = 780.0;

// Lumens per watt of light of 555 nm: Y of a radiance in W m-2 sr-1 nm-1, integrated over nm, times this is in cd/m2.
constexpr double kLuminousEfficacy = 683.0;

// CIE 1931 2-degree observer (CIE 15, 5 nm table, linear in between), zero outside 380-780 nm.
glm::dvec3 colour_matching(double wavelength_nm);

// The CIE's components of daylight S0, S1, S2 (CIE 15, 10 nm table, linear in between as CIE 15 prescribes), zero
// outside 380-780 nm.
glm::dvec3 daylight_components(double wavelength_nm);

// M1 and M2 of a chromaticity, unrounded: its daylight is S0 + M1 S1 + M2 S2.
struct DaylightWeights {
  double m1 = 0.0;
  double m2 = 0.0;
};
DaylightWeights daylight_weights(double x, double y);

// Relative spectral power of the daylight of a chromaticity, 100 near 560 nm. Not clamped: far from the daylight locus
// some wavelengths turn negative, and only so do the colours come out right.
double daylight_spectrum(double x, double y, double wavelength_nm);

// Linear sRGB to XYZ (IEC 61966-2-1), white (1, 1, 1) to D65 with Y = 1.
glm::dmat3 srgb_to_xyz();
// Its inverse as the standard prints it, rounded too: there and back is off by some 1e-4. Where light goes both ways,
// glm::inverse(srgb_to_xyz()) is taken instead.
glm::dmat3 xyz_to_linear_srgb();

}  // namespace kasumi
