#include "estimator/sky/sun.hpp"

#include <cmath>

#include <erfa.h>

namespace kasumi {

namespace {

constexpr double kWavelengthUm = 0.55;  // of refraction: the middle of the visible spectrum
constexpr double kUt1MinusUtc = 0.0;    // below .9 s by definition: .004 deg of the sun's way

// ERFA's two-part date of an instant; a day with a leap second is 86401 s long there.
struct JulianDate {
  double day = 0.0;
  double rest = 0.0;
};
JulianDate julian_date(Utc utc) {
  const auto day = std::chrono::floor<std::chrono::days>(utc);
  const std::chrono::year_month_day date{day};
  const std::chrono::hh_mm_ss time{utc - day};
  JulianDate julian;
  const double seconds = static_cast<double>(time.seconds().count()) + to_seconds(time.subseconds());
  eraDtf2d("UTC", static_cast<int>(date.year()), static_cast<int>(static_cast<unsigned>(date.month())),
           static_cast<int>(static_cast<unsigned>(date.day())), static_cast<int>(time.hours().count()),
           static_cast<int>(time.minutes().count()), seconds, &julian.day, &julian.rest);
  return julian;
}

}  // namespace

SurfaceWeather standard_air(double altitude_m) {
  const double kelvin = 288.15 - 0.0065 * altitude_m;
  return {1013.25 * std::pow(kelvin / 288.15, 5.25588), kelvin - 273.15, 0.5};
}

SunPosition sun_position(Utc utc, const Site& site, const std::optional<SurfaceWeather>& air) {
  const SurfaceWeather a = air ? *air : standard_air(site.altitude_m);
  const JulianDate date = julian_date(utc);
  eraASTROM observer;
  double equation_of_origins = 0.0;
  eraApco13(date.day, date.rest, kUt1MinusUtc, from_degrees(site.longitude_deg).value,
            from_degrees(site.latitude_deg).value, site.altitude_m, 0.0, 0.0, a.pressure_hpa, a.temperature_c,
            a.relative_humidity, kWavelengthUm, &observer, &equation_of_origins);

  // The sun as seen from the site (parallax included), then aberration, precession and nutation, the earth's rotation
  // and refraction. Light time needs no separate step: the sun hardly moves around the barycentre.
  double geometric[3] = {-observer.eh[0], -observer.eh[1], -observer.eh[2]};
  double aberrated[3], intermediate[3];
  eraAb(geometric, observer.v, observer.em, observer.bm1, aberrated);
  eraRxp(observer.bpn, aberrated, intermediate);
  double right_ascension = 0.0, declination = 0.0;
  eraC2s(intermediate, &right_ascension, &declination);
  double azimuth = 0.0, zenith = 0.0, hour_angle = 0.0, observed_declination = 0.0, observed_right_ascension = 0.0;
  eraAtioq(eraAnp(right_ascension), declination, &observer, &azimuth, &zenith, &hour_angle, &observed_declination,
           &observed_right_ascension);
  const SunPosition position{{zenith}, {azimuth}, direction_from({zenith}, {azimuth})};
  return position;
}

}  // namespace kasumi
