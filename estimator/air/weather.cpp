// T in the terms of meteorologists and visitors.
#include <cmath>

#include "estimator/air/scattering.hpp"
#include "estimator/atmosphere.hpp"

namespace kasumi {

std::string_view name_of(WeatherClass weather) {
  switch (weather) {
    case WeatherClass::pure_air: return "pure air";
    case WeatherClass::exceptionally_clear: return "exceptionally clear";
    case WeatherClass::very_clear: return "very clear";
    case WeatherClass::clear: return "clear";
    case WeatherClass::light_haze: return "light haze";
    case WeatherClass::haze: return "haze";
    case WeatherClass::fog: return "fog";
  }
  return "unknown";
}

double meteorological_range_m(const AirState& air, double altitude_m, ScatteringModel model) {
  constexpr double kContrastThreshold = 3.912;  // -ln .02
  return kContrastThreshold / (rayleigh_per_m(model, 550.0, altitude_m) + mie_per_m(model, 550.0, air, altitude_m));
}

double aerosol_optical_depth(Turbidity turbidity, double wavelength_nm) {
  const double beta = std::max(0.0, 0.04608 * turbidity.value - 0.04586);
  return beta * std::pow(wavelength_nm / 1000.0, -1.3);
}

WeatherClass weather_class(double mie_per_m) {
  const double per_km = mie_per_m * 1000.0;
  if (per_km <= 0.0) return WeatherClass::pure_air;
  if (per_km < 0.0639) return WeatherClass::exceptionally_clear;
  if (per_km < 0.1819) return WeatherClass::very_clear;
  if (per_km < 0.3769) return WeatherClass::clear;
  if (per_km < 0.9399) return WeatherClass::light_haze;
  if (per_km < 1.9459) return WeatherClass::haze;
  return WeatherClass::fog;
}

AirQuality air_quality(const AirState& air, double altitude_m) {
  const auto model = air.aerosol_known() ? ScatteringModel::aerosol : ScatteringModel::morales2017;
  AirQuality quality;
  quality.turbidity = air.turbidity();
  quality.aod_550 = air.aerosol_known() ? air.aerosol().aod_550 : aerosol_optical_depth(air.turbidity(), 550.0);
  quality.visibility_m = meteorological_range_m(air, altitude_m, model);
  // The class describes the air around the visitor, so that it never contradicts the visibility shown next to it.
  quality.weather = weather_class(mie_per_m(model, 550.0, air, altitude_m));
  if (air.aerosol_known()) quality.aerosol = air.aerosol();
  return quality;
}

}  // namespace kasumi
