// The sun's apparent position, from time and place (ERFA).
#pragma once

#include <optional>

#include "base/clock.hpp"
#include "base/units.hpp"
#include "calib/camera.hpp"
#include "estimator/atmosphere.hpp"

namespace kasumi {

// The air at the observer; only refraction depends on it.
struct SurfaceWeather {
  double pressure_hpa = 1013.25;
  double temperature_c = 15.0;
  double relative_humidity = 0.5;  // 0..1
};
// International standard atmosphere at an altitude.
SurfaceWeather standard_air(double altitude_m);

struct SunPosition {
  Radians zenith;   // apparent: refraction included
  Radians azimuth;  // clockwise from true north
  SunDirection direction{0.0, 0.0, 1.0};
};

// Topocentric, apparent. Leap seconds come from ERFA's own table. UT1 - UTC is taken as 0: it stays below 0.9 s, which
// is 0.004 deg of hour angle. Refraction is ERFA's two-term model, good to arc seconds above 5 deg and to about 0.1 deg
// at the horizon, where no estimate is made anyway. Without `air` the standard atmosphere at the site's altitude is
// used.
SunPosition sun_position(Utc utc, const Site& site, const std::optional<SurfaceWeather>& air = std::nullopt);

}  // namespace kasumi
