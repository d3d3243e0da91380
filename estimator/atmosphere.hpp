// What the estimator knows about today's air and passes to the renderer.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "base/clock.hpp"
#include "base/geometry.hpp"

namespace kasumi {

// Ratio of the optical thickness of haze and air to that of air alone (M Eq 5). 1 is pure air; the sky model is valid
// from 1.7 to 20.
struct Turbidity {
  double value = 2.0;
  friend constexpr auto operator<=>(Turbidity, Turbidity) = default;
};
constexpr Turbidity kLowestTurbidity{1.7};
constexpr Turbidity kHighestTurbidity{20.0};

using SunDirection = Direction;  // towards the sun, world frame

enum class WeatherClass { pure_air, exceptionally_clear, very_clear, clear, light_haze, haze, fog };
std::string_view name_of(WeatherClass weather);  // "light haze"

enum class SkyCondition { clear, partly_cloudy, overcast, sun_too_low, night, covered_lens, unknown };
std::string_view name_of(SkyCondition condition);  // "partly cloudy"

// T and the quantities derived from it, each under its own name.
struct AirQuality {
  Turbidity turbidity;
  double aod_550 = 0.0;       // aerosol optical depth by Angstrom
  double visibility_m = 0.0;  // meteorological range 3.912 / beta at 550 nm and the site's altitude
  WeatherClass weather = WeatherClass::clear;
};
AirQuality air_quality(Turbidity turbidity, double altitude_m);

// The result for one sky picture.
struct TurbidityEstimate {
  bool usable = false;
  std::string reason;  // for people: "rejected: 212 clear samples < 500 (clouds 81 %)"; empty when usable
  SkyCondition sky = SkyCondition::unknown;
  Turbidity turbidity;          // valid when usable
  double sigma = 0.0;           // standard deviation of T; valid when usable
  double clear_fraction = 0.0;  // of the sky that was examined
  int samples = 0;              // used in the fit
  double log_residual = 0.0;    // root mean square of ln(measured/model) over the inliers
  SunDirection sun{0.0, 0.0, 1.0};
};

}  // namespace kasumi
