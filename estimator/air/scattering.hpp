// How strongly a metre of air and haze scatters light out of a ray (M Sect 3.1 and 5; physics 3).
#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "estimator/atmosphere.hpp"

namespace kasumi {

// morales2017: ours (M Eq 14-18). preetham: c = (.6544T - .6510)e-16 with K(lambda) in .65-.69, as M used it;
// Preetham's published code has a unit factor of .01 that M did not apply. zhao: the same with e-18. aerosol: no paper's
// law but the air's own state: molecules after Bodhaine 1999, the aerosol's optical depth over 1200 m (physics 12).
enum class ScatteringModel { morales2017, preetham, zhao, aerosol };
// All of them, as options list them.
inline constexpr std::array kScatteringModels{ScatteringModel::morales2017, ScatteringModel::preetham,
                                              ScatteringModel::zhao, ScatteringModel::aerosol};
std::string_view name_of(ScatteringModel model);
std::optional<ScatteringModel> scattering_model_named(std::string_view name);

constexpr double kRayleighScaleHeight_m = 7994.0;  // M Eq 3
constexpr double kMieScaleHeight_m = 1200.0;       // M Eq 4

// Coefficients in 1/m of the air near the ground. Wavelength in nm, altitude in metres above sea level. Turbidities for
// which a model's concentration would be negative (below 1, or .995) give zero. Of the aerosol the papers' models know
// T alone; AirState::near_ground scales all of them.
double rayleigh_per_m(ScatteringModel model, double wavelength_nm, double altitude_m = 0.0);  // M Eq 3, 15
double mie_per_m(ScatteringModel model, double wavelength_nm, const AirState& air,
                 double altitude_m = 0.0);  // M Eq 4, 18
// Optical depth of the standard atmosphere's molecules from sea level (Bodhaine 1999, Eq 30).
double molecular_optical_depth(double wavelength_nm);

// Preetham's fudge factor K, 380-780 nm (Preetham 1999, Table 2), linear between its 10 nm steps, held outside.
double preetham_fudge_factor(double wavelength_nm);

// Koschmieder at 550 nm: 3.912 / (beta_R + beta_M). Metres.
double meteorological_range_m(const AirState& air, double altitude_m,
                              ScatteringModel model = ScatteringModel::morales2017);
// Angstrom's aerosol optical depth of the whole column, (.04608T - .04586) lambda^-1.3 with lambda in micrometres.
double aerosol_optical_depth(Turbidity turbidity, double wavelength_nm);
// M Table 2, from the Mie coefficient at 550 nm in 1/m.
WeatherClass weather_class(double mie_per_m);

}  // namespace kasumi
