#include "estimator/air/scattering.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/units.hpp"

namespace kasumi {
namespace {

// M Eq 3 at sea level, before the correction K_R.
constexpr double kRefractiveIndex = 1.0003;
constexpr double kMoleculesPerM3 = 2.545e25;
constexpr double kDepolarisation = 0.035;
// Makes the coefficient at 550 nm the .0141 /km of M Table 2. M prints .0141/.0135 = 1.0396; that quotient is in fact
// 1.0444, and 1.0396 is what Eq 3 itself (.0135629 /km) requires.
constexpr double kRayleighCorrection = 1.0396;
constexpr double kMieCorrection = 0.0092;  // M Eq 17
// Height of the column if all air had the density at sea level: base/sky/air_path.glsl's.
constexpr double kAirColumn_m = 8434.5;

// 380-780 nm in steps of 10 nm.
constexpr std::array kPreethamK = {
    0.650393, 0.653435, 0.656387, 0.657828, 0.660644, 0.662016, 0.663365, 0.665996, 0.667276, 0.668532, 0.669765,
    0.670974, 0.672160, 0.673323, 0.674462, 0.675578, 0.676670, 0.677739, 0.678784, 0.678781, 0.679802, 0.680800,
    0.681775, 0.681771, 0.682722, 0.683649, 0.683646, 0.684550, 0.684546, 0.685426, 0.686282, 0.686279, 0.687112,
    0.687108, 0.687917, 0.687913, 0.688699, 0.688695, 0.688691, 0.689453, 0.689449};

// c(T) K(lambda)
double concentration_and_fudge(ScatteringModel model, double wavelength_nm, double turbidity) {
  switch (model) {
    case ScatteringModel::morales2017: return std::max(0.0, 0.65 * turbidity - 0.65) * 1e-16 * kMieCorrection;
    case ScatteringModel::preetham:
      return std::max(0.0, 0.6544 * turbidity - 0.6510) * 1e-16 * preetham_fudge_factor(wavelength_nm);
    case ScatteringModel::zhao:
      return std::max(0.0, 0.6544 * turbidity - 0.6510) * 1e-18 * preetham_fudge_factor(wavelength_nm);
    case ScatteringModel::aerosol: break;  // has no concentration
  }
  return 0.0;
}

}  // namespace

std::string_view name_of(ScatteringModel model) {
  switch (model) {
    case ScatteringModel::morales2017: return "morales2017";
    case ScatteringModel::preetham: return "preetham";
    case ScatteringModel::zhao: return "zhao";
    case ScatteringModel::aerosol: return "aerosol";
  }
  return "unknown";
}

std::optional<ScatteringModel> scattering_model_named(std::string_view name) {
  for (const auto model : kScatteringModels) {
    if (name == name_of(model)) return model;
  }
  return std::nullopt;
}

double preetham_fudge_factor(double wavelength_nm) {
  const double position = std::clamp((wavelength_nm - 380.0) / 10.0, 0.0, static_cast<double>(kPreethamK.size() - 1));
  const auto below = std::min(static_cast<std::size_t>(position), kPreethamK.size() - 2);
  return std::lerp(kPreethamK[below], kPreethamK[below + 1], position - static_cast<double>(below));
}

double molecular_optical_depth(double wavelength_nm) {
  const double um = 1e-3 * wavelength_nm, s = 1.0 / (um * um);
  return 0.0021520 * (1.0455996 - 341.29061 * s - 0.90230850 / s) / (1.0 + 0.0027059889 * s - 85.968563 / s);
}

double rayleigh_per_m(ScatteringModel model, double wavelength_nm, double altitude_m) {
  if (model == ScatteringModel::aerosol)
    return molecular_optical_depth(wavelength_nm) / kAirColumn_m * std::exp(-altitude_m / kRayleighScaleHeight_m);
  const double wavelength_m = wavelength_nm * 1e-9;
  const double n2_minus_1 = kRefractiveIndex * kRefractiveIndex - 1.0;
  const double king = (6.0 + 3.0 * kDepolarisation) / (6.0 - 7.0 * kDepolarisation);
  const double coefficient =
      8.0 * std::pow(kPi, 3) * n2_minus_1 * n2_minus_1 / (3.0 * kMoleculesPerM3 * std::pow(wavelength_m, 4)) * king;
  const double correction = model == ScatteringModel::morales2017 ? kRayleighCorrection : 1.0;
  return coefficient * correction * std::exp(-altitude_m / kRayleighScaleHeight_m);
}

double mie_per_m(ScatteringModel model, double wavelength_nm, const AirState& air, double altitude_m) {
  if (model == ScatteringModel::aerosol)
    return air.near_ground() * optical_depth(air.aerosol(), wavelength_nm) / kAerosolHeight_m *
           std::exp(-altitude_m / kAerosolHeight_m);
  const double wave_number = 2.0 * kPi / (wavelength_nm * 1e-9);
  return air.near_ground() * 0.434 * concentration_and_fudge(model, wavelength_nm, air.turbidity().value) * kPi *
         wave_number * wave_number * std::exp(-altitude_m / kMieScaleHeight_m);
}

}  // namespace kasumi
