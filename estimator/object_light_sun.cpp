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

// Means of 10 nm, 370-380, 380-390, ... 780-790: first centre 375 nm. W m-2 nm-1.
constexpr std::array kSolar = {1.14259, 1.01249, 1.14716, 1.72765, 1.73054, 1.68870, 1.61253, 1.91198, 2.03474,
                               2.02042, 2.02212, 1.93377, 1.95809, 1.91686, 1.82980, 1.86850, 1.89310, 1.85149,
                               1.85040, 1.83410, 1.83450, 1.81470, 1.78158, 1.75330, 1.69650, 1.68194, 1.64654,
                               1.60480, 1.52143, 1.55622, 1.51130, 1.47400, 1.44820, 1.41018, 1.36775, 1.34188,
                               1.31429, 1.28303, 1.26758, 1.23670, 1.20820, 1.18737};

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
  return EvenTable{375.0, 10.0, kSolar.data(), static_cast<int>(kSolar.size())}.at(wavelength_nm);
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
