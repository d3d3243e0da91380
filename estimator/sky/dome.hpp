// The clear sky seen from any altitude to 30 km, through any aerosol, under any sun: fitted to a spectral atmosphere with all
// orders of scattering (fixtures/atmosphere makes the table; docs/sky.md gives the accuracy). After U Chapter 3, whose
// own table cannot be used (physics 10).
#pragma once

#include <array>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "base/aerosol.hpp"
#include "base/sky/dome_function.hpp"
#include "estimator/atmosphere.hpp"

namespace kasumi {

constexpr double kHighestDomeAltitude_m = 30000.0;      // the highest of U's altitudes
constexpr double kHighestDomeAod = 1.8;                 // at 550 nm
constexpr Turbidity kHighestDomeTurbidity{10.0};        // to which T is fitted: an aod_550 of .90
constexpr Radians kLowestDomeSun = from_degrees(92.0);  // zenith angle, without refraction

// For an exponent that is not the kind's own each channel of linear sRGB is that of the sky whose aerosol has the asked
// optical depth at this wavelength.
constexpr glm::dvec3 kDomeChannels_nm{640.0, 542.0, 441.0};

// Of a blend of two kinds each channel is the mean of their skies by their shares of its depth, both having all of it:
// exact for light scattered once, within .3 to 1.2 % of the spectral atmosphere up to a depth of .4 (docs/sky.md).
//
// All arguments are clamped to the table's range: altitude 0 .. 30 km, aod_550 0 .. 1.8, sun's zenith angle 0 .. 92 deg
// (a lower sun gives the sky of 92 deg with the sun's direction lifted to it). Light: CIE XYZ, Y in cd/m2, at the
// earth's mean distance from the sun. Interpolates in a table in memory: 25 us, 65 us at an exponent that is not the
// kind's own.
DomeFunction dome(double altitude_m, const Aerosol& aerosol, const SunDirection& sun);

// Light of the sun's disc that reaches the observer through the same air; XYZ, lux and cd/m2.
SunLight dome_sun(double altitude_m, const Aerosol& aerosol, const SunDirection& sun);

// What a wavelength sees of the aerosol: each kind's share of the depth there, and the optical depth at 550 nm with which
// that kind, at its natural exponent, has the whole depth there.
struct KindInChannel {
  AerosolKind kind = AerosolKind::continental;
  double share = 0.0, aod_550 = 0.0;
};
std::array<KindInChannel, 2> kinds_in_channel(const Aerosol& aerosol, double wavelength_nm);

// Of the aerosol that a turbidity stands for (aerosol_of).
inline DomeFunction dome(double altitude_m, Turbidity turbidity, const SunDirection& sun) {
  return dome(altitude_m, aerosol_of(turbidity.value), sun);
}
inline SunLight dome_sun(double altitude_m, Turbidity turbidity, const SunDirection& sun) {
  return dome_sun(altitude_m, aerosol_of(turbidity.value), sun);
}

// The same sky in another linear space: the coefficients multiplied from the left. For example xyz_to_linear_srgb() of
// calib/colour/colorimetry.hpp: D65 white, 1.0 stays 1 cd/m2.
DomeFunction in_space(DomeFunction sky, const glm::dmat3& xyz_to_space);

// Light from one direction, in double precision: the reference for base/sky/dome.glsl. Below the horizon the horizon's
// value at that azimuth.
glm::dvec3 dome_light(const DomeFunction& sky, const Direction& view);

// Sine of the geometric horizon's elevation at an altitude: -sqrt(1 - (R / (R + h))^2), R = 6371 km.
double horizon_sine(double altitude_m);

}  // namespace kasumi
