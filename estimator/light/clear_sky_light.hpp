// The illuminance of the clear sky and the sun, to which the sky model's distribution is scaled.
#pragma once

#include "base/units.hpp"
#include "estimator/atmosphere.hpp"

namespace kasumi {

// Kasten and Young's relative optical air mass; held below the horizon.
double air_mass(Radians sun_zenith);
// Extraterrestrial irradiance at the mean distance (Preetham 1999, Table 2). W m-2 nm-1.
double solar_irradiance(double wavelength_nm);

// Optical depths of the air above the site, straight up, at one wavelength.
struct ColumnDepth {
  double rayleigh = 0.0;
  double aerosol = 0.0;
  double ozone = 0.0;
};
// Rayleigh (Preetham 1999 A.1, by the site's pressure), aerosol (Angstrom), ozone (.35 cm). Water vapour and oxygen,
// which absorb some percent beyond 680 nm, are left out. T was measured at the site, so it describes the haze above it
// at any altitude.
ColumnDepth column_depth(Turbidity turbidity, double altitude_m, double wavelength_nm);

// Share of direct sunlight that reaches the site.
double sun_transmittance(const ColumnDepth& depth, Radians sun_zenith);
double sun_transmittance(Turbidity turbidity, Radians sun_zenith, double altitude_m, double wavelength_nm);

// Diffuse irradiance of the whole clear sky on level ground, per extraterrestrial irradiance on a surface facing the
// sun: Bird and Riordan's simple spectral model (SPCTRAL2, J. Climate Appl. Meteorol. 25, 1986), rural aerosol, with
// interreflection between ground and sky. Zero at and below the horizon.
double sky_transmittance(const ColumnDepth& depth, Radians sun_zenith, double ground_albedo, double wavelength_nm);

// The same in lux, with a minimum of 800 lx, what remains when the sun is on the horizon (IES RP-21, 1984).
double clear_sky_lux(Turbidity turbidity, Radians sun_zenith, double altitude_m, double ground_albedo);

}  // namespace kasumi
