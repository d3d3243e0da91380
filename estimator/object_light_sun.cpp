// Direct sunlight at the ground, by wavelength.
#include <algorithm>
#include <array>
#include <cmath>

#include "estimator/object_light.hpp"
#include "estimator/scattering.hpp"

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
// 1999, Table 2). The sky model was made with this sun, so sun and sky keep their ratio: newer spectra (ASTM G173) are
// 5-7 % brighter.
constexpr std::array kSolar = {1655.90, 1623.37, 2112.75, 2588.82, 2582.91, 2423.23, 2676.05, 2965.83, 3054.54, 3005.75,
                               3066.37, 2883.04, 2871.21, 2782.50, 2710.06, 2723.36, 2636.13, 2550.38, 2506.02, 2531.16,
                               2535.59, 2513.42, 2463.15, 2417.32, 2368.53, 2321.21, 2282.77, 2233.98, 2197.02, 2152.67,
                               2109.79, 2072.83, 2024.04, 1987.08, 1942.72, 1907.24, 1862.89, 1825.92};
constexpr double kSunDisc_sr = 6.797e-5;  // of .2665 deg radius, at the mean distance

// Ozone's absorption, 1/cm, 440-790 nm in 10 nm steps (Preetham 1999, Table 2, after Iqbal 1983).
constexpr std::array kOzone = {0.0,   0.003, 0.006, 0.009, 0.014, 0.021, 0.030, 0.040, 0.048, 0.063, 0.075, 0.085,
                               0.103, 0.120, 0.120, 0.115, 0.125, 0.120, 0.105, 0.090, 0.079, 0.067, 0.057, 0.048,
                               0.036, 0.028, 0.023, 0.018, 0.014, 0.011, 0.010, 0.009, 0.007, 0.004, 0.0,   0.0};
constexpr double kOzone_cm = 0.35;

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

double sun_transmittance(Turbidity turbidity, Radians sun_zenith, double altitude_m, double wavelength_nm) {
  const double micrometres = wavelength_nm / 1000.0;
  const double pressure = std::exp(-altitude_m / kRayleighScaleHeight_m);
  const double rayleigh = 0.008735 * std::pow(micrometres, -4.08) * pressure;
  // T was measured at the site, so it describes the haze above the site whatever its altitude.
  const double aerosol = aerosol_optical_depth(turbidity, wavelength_nm);
  const double ozone =
      kOzone_cm * EvenTable{440.0, 10.0, kOzone.data(), static_cast<int>(kOzone.size())}.at(wavelength_nm);
  return std::exp(-air_mass(sun_zenith) * (rayleigh + aerosol + ozone));
}

}  // namespace kasumi
