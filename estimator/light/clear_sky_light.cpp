#include "estimator/light/clear_sky_light.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/sky/sun_disc.hpp"
#include "calib/colour/colorimetry.hpp"
#include "estimator/air/scattering.hpp"

namespace kasumi {
namespace {

struct EvenTable {
  double first_nm;
  double step_nm;
  const double* values;
  int size;
  double at(double nm) const {
    const double position = std::clamp((nm - first_nm) / step_nm, 0.0, size - 1.0);
    const int below = std::min(static_cast<int>(position), size - 2);
    return std::lerp(values[below], values[below + 1], position - below);
  }
};

// Radiance of the sun's disc above the atmosphere, W cm-2 um-1 sr-1, 380-750 nm in 10 nm steps, held beyond (Preetham
// 1999, Table 2). Newer spectra (ASTM G173) are 5-7 % brighter; sun and sky both use this one, so only its shape
// matters.
constexpr std::array kSolar = {1655.90, 1623.37, 2112.75, 2588.82, 2582.91, 2423.23, 2676.05, 2965.83, 3054.54, 3005.75,
                               3066.37, 2883.04, 2871.21, 2782.50, 2710.06, 2723.36, 2636.13, 2550.38, 2506.02, 2531.16,
                               2535.59, 2513.42, 2463.15, 2417.32, 2368.53, 2321.21, 2282.77, 2233.98, 2197.02, 2152.67,
                               2109.79, 2072.83, 2024.04, 1987.08, 1942.72, 1907.24, 1862.89, 1825.92};

// Ozone's absorption, 1/cm, 440-790 nm in 10 nm steps (Preetham 1999, Table 2, after Iqbal 1983).
constexpr std::array kOzone = {0.0,   0.003, 0.006, 0.009, 0.014, 0.021, 0.030, 0.040, 0.048, 0.063, 0.075, 0.085,
                               0.103, 0.120, 0.120, 0.115, 0.125, 0.120, 0.105, 0.090, 0.079, 0.067, 0.057, 0.048,
                               0.036, 0.028, 0.023, 0.018, 0.014, 0.011, 0.010, 0.009, 0.007, 0.004, 0.0,   0.0};
constexpr double kOzone_cm = 0.35;  // physics 6

// Chosen: of the order of a clear sky at sunset, below which SPCTRAL2 does not go.
constexpr double kLeastClearSky_lux = 800.0;

// The rural aerosol of Bird and Riordan.
constexpr double kAsymmetry = 0.65;
constexpr double kMassOfDiffuseLight = 1.8;
double scattering_albedo(double micrometres) {
  const double from_blue = std::log(micrometres / 0.4);
  return 0.945 * std::exp(-0.095 * from_blue * from_blue);
}

// Share of the light scattered by aerosol that continues downwards, for a cosine of incidence (their Eqs 3-11 to 3-15).
double forward_share(double cosine) {
  const double g = std::log(1.0 - kAsymmetry);
  const double a = g * (1.459 + g * (0.1595 + g * 0.4129));
  const double b = g * (0.0783 + g * (-0.3824 - g * 0.5874));
  return 1.0 - 0.5 * std::exp((a + b * cosine) * cosine);
}

}  // namespace

double air_mass(Radians sun_zenith) {
  const double degrees = std::clamp(to_degrees(sun_zenith), 0.0, 90.0);
  return 1.0 / (std::cos(from_degrees(degrees).value) + 0.50572 * std::pow(96.07995 - degrees, -1.6364));
}

double solar_irradiance(double wavelength_nm) {
  constexpr double kToPerM2PerNm = 10.0;  // from W cm-2 um-1
  return kSunDisc_sr * kToPerM2PerNm *
         EvenTable{380.0, 10.0, kSolar.data(), static_cast<int>(kSolar.size())}.at(wavelength_nm);
}

ColumnDepth column_depth(Turbidity turbidity, double altitude_m, double wavelength_nm) {
  const double pressure = std::exp(-altitude_m / kRayleighScaleHeight_m);
  return {0.008735 * std::pow(wavelength_nm / 1000.0, -4.08) * pressure,
          aerosol_optical_depth(turbidity, wavelength_nm),
          kOzone_cm * EvenTable{440.0, 10.0, kOzone.data(), static_cast<int>(kOzone.size())}.at(wavelength_nm)};
}

double sun_transmittance(const ColumnDepth& depth, Radians sun_zenith) {
  return std::exp(-air_mass(sun_zenith) * (depth.rayleigh + depth.aerosol + depth.ozone));
}

double sun_transmittance(Turbidity turbidity, Radians sun_zenith, double altitude_m, double wavelength_nm) {
  return sun_transmittance(column_depth(turbidity, altitude_m, wavelength_nm), sun_zenith);
}

double sky_transmittance(const ColumnDepth& depth, Radians sun_zenith, double ground_albedo, double wavelength_nm) {
  const double cosine = std::cos(sun_zenith.value);
  if (cosine <= 0.0) return 0.0;
  const double micrometres = wavelength_nm / 1000.0, scattered = scattering_albedo(micrometres);
  const auto through = [](double d, double mass) { return std::exp(-d * mass); };

  const double mass = air_mass(sun_zenith);
  const double rayleigh = through(depth.rayleigh, mass);
  const double absorption = through(depth.ozone, mass) * through((1.0 - scattered) * depth.aerosol, mass);
  const double by_air = cosine * absorption * 0.5 * (1.0 - std::pow(rayleigh, 0.95));
  const double by_aerosol = cosine * absorption * std::pow(rayleigh, 1.5) *
                            (1.0 - through(scattered * depth.aerosol, mass)) * forward_share(cosine);

  // Interreflection between ground and sky.
  const double rayleigh_back = through(depth.rayleigh, kMassOfDiffuseLight);
  const double sky_albedo =
      through((1.0 - scattered) * depth.aerosol, kMassOfDiffuseLight) *
      (0.5 * (1.0 - rayleigh_back) + (1.0 - forward_share(1.0 / kMassOfDiffuseLight)) * rayleigh_back *
                                         (1.0 - through(scattered * depth.aerosol, kMassOfDiffuseLight)));
  const double both = sky_albedo * ground_albedo;
  const double by_ground = (cosine * sun_transmittance(depth, sun_zenith) + by_air + by_aerosol) * both / (1.0 - both);
  const double blue_excess = micrometres <= 0.45 ? std::pow(micrometres + 0.55, 1.8) : 1.0;
  return (by_air + by_aerosol + by_ground) * blue_excess;
}

double clear_sky_lux(Turbidity turbidity, Radians sun_zenith, double altitude_m, double ground_albedo) {
  constexpr double kStep_nm = 5.0;  // half the step of the tables
  double lux = 0.0;
  for (double nm = kFirstVisible_nm; nm <= kLastVisible_nm; nm += kStep_nm)
    lux += kStep_nm * kLuminousEfficacy * colour_matching(nm).y * solar_irradiance(nm) *
           sky_transmittance(column_depth(turbidity, altitude_m, nm), sun_zenith, ground_albedo, nm);
  return std::max(lux, kLeastClearSky_lux);
}

}  // namespace kasumi
