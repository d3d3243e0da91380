#include "estimator/air_path.hpp"

#include <algorithm>
#include <cmath>

#include "calib/colorimetry.hpp"
#include "estimator/attenuation.hpp"

namespace kasumi {
namespace {

constexpr double kEarthRadius_m = 6371000.0;
constexpr double kAerosolScaleHeight_m = 1200.0;
constexpr double kClosestEnds_m = 50.0;

// US standard atmosphere 1976: a troposphere of constant lapse rate, above it one temperature. The pressure over that
// of sea level; the real one is 6 % lower at 30 km, where 1 % of the air is left.
double pressure_share(double altitude_m) {
  constexpr double tropopause_m = 11000.0, scale_m = 44330.77, exponent = 5.25588, above_scale_m = 6341.62;
  const double share = std::pow(1.0 - std::min(altitude_m, tropopause_m) / scale_m, exponent);
  return altitude_m <= tropopause_m ? share : share * std::exp(-(altitude_m - tropopause_m) / above_scale_m);
}
// Pressure over (density of sea level times g): the height of a column of sea-level air.
constexpr double kAirColumn_m = 8434.5;

// Green's profile of ozone: the layer's middle at 22.5 km, its steepness 4.7 km.
double ozone_share(double altitude_m) {
  constexpr double middle_m = 22500.0, width_m = 4700.0;
  return (1.0 + std::exp(-middle_m / width_m)) / (1.0 + std::exp((altitude_m - middle_m) / width_m));
}

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
  // IEC 61966-2-1; columns are X, Y, Z
  const glm::dmat3 to_srgb(3.2406, -0.9689, 0.0557, -1.5372, 1.8758, -0.2040, -0.4986, 0.0415, 1.0570);
  SpectralMeasure measure;
  glm::dvec3 sum{0};
  for (double nm = kFirstVisible_nm; nm <= kLastVisible_nm; nm += 1.0) {
    measure.weight.push_back(to_srgb * colour_matching(nm) * daylight_spectrum(0.3127, 0.3290, nm));
    sum += measure.weight.back();
  }
  for (glm::dvec3& weight : measure.weight) weight /= sum;
  return measure;
}

// The path grows by its sag below the straight line between its ends' altitudes.
double sagged(double column, double distance_m, double rise_m, double scale_height_m) {
  const double steepness = rise_m / scale_height_m;
  return column * std::exp(distance_m * distance_m / (2.0 * kEarthRadius_m * scale_height_m) /
                           std::sqrt(36.0 + steepness * steepness));
}

}  // namespace

AirColumns columns_above(double altitude_m) {
  return {kAirColumn_m * pressure_share(altitude_m),
          kAerosolScaleHeight_m * std::exp(-altitude_m / kAerosolScaleHeight_m), ozone_share(altitude_m)};
}

AirColumns columns_between(double altitude_0_m, double altitude_1_m, double distance_m) {
  const double middle = 0.5 * (altitude_0_m + altitude_1_m), rise = std::abs(altitude_1_m - altitude_0_m);
  const double half = 0.5 * std::max(rise, kClosestEnds_m);
  const AirColumns low = columns_above(middle - half), high = columns_above(middle + half);
  const double slant = distance_m / (2.0 * half);
  constexpr double air_scale_height_m = 8000.0;
  return {sagged(slant * (low.molecules_m - high.molecules_m), distance_m, rise, air_scale_height_m),
          sagged(slant * (low.aerosol_m - high.aerosol_m), distance_m, rise, kAerosolScaleHeight_m),
          slant * (low.ozone - high.ozone)};
}

AirCoefficients air_coefficients(Turbidity turbidity) {
  static const AttenuationNodes nodes = attenuation_nodes(srgb_measure());
  AirCoefficients air;
  for (int n = 0; n < kAirNodes; ++n) {
    air.weight[n] = nodes.weight[n];
    for (int c = 0; c < 3; ++c) {
      const double nm = nodes.wavelength_nm[n][c];
      air.molecules_per_m[n][c] = static_cast<float>(molecular_depth(nm) / kAirColumn_m);
      air.aerosol_per_m[n][c] = static_cast<float>(aerosol_optical_depth(turbidity, nm) / kAerosolScaleHeight_m);
      air.ozone[n][c] = static_cast<float>(kOzone_cm * ozone_per_cm(nm));
    }
  }
  return air;
}

glm::dvec3 transparency(const AirCoefficients& air, const AirColumns& path) {
  glm::dvec3 left{0};
  for (int n = 0; n < kAirNodes; ++n)
    left += glm::dvec3(air.weight[n]) *
            glm::exp(-(glm::dvec3(air.molecules_per_m[n]) * path.molecules_m +
                       glm::dvec3(air.aerosol_per_m[n]) * path.aerosol_m + glm::dvec3(air.ozone[n]) * path.ozone));
  return glm::clamp(left, 0.0, 1.0);
}

}  // namespace kasumi
