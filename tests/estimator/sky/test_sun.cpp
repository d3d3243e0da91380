#include <gtest/gtest.h>

#include "estimator/sky/sun.hpp"

namespace kasumi {
namespace {

using namespace std::chrono;

Utc at(int year, unsigned month, unsigned day, int hour, int minute, int second) {
  return sys_days{std::chrono::year{year} / std::chrono::month{month} / std::chrono::day{day}} + hours{hour} +
         minutes{minute} + seconds{second};
}

// Reda and Andreas, NREL/TP-560-34302, appendix A.5.
TEST(Sun, StandsWhereNrelsPublishedExampleHasIt) {
  const Site golden{"Golden", 39.742476, -105.1786, 1830.14};
  const SunPosition sun = sun_position(at(2003, 10, 17, 19, 30, 30), golden, SurfaceWeather{820.0, 11.0, 0.0});
  EXPECT_NEAR(to_degrees(sun.zenith), 50.111622, 0.003);
  EXPECT_NEAR(to_degrees(sun.azimuth), 194.340241, 0.003);
  RecordProperty("zenith_deg", std::to_string(to_degrees(sun.zenith)));
  std::printf("zenith %.6f (50.111622), azimuth %.6f (194.340241)\n", to_degrees(sun.zenith), to_degrees(sun.azimuth));
}

TEST(Sun, DirectionIsItsZenithAndAzimuth) {
  const SunPosition sun = sun_position(at(2026, 6, 21, 3, 0, 0), {"Asuka", 34.47, 135.82, 134.0});
  EXPECT_LT(angle_between(sun.direction, direction_from(sun.zenith, sun.azimuth)).value, 1e-12);
}

// At the June solstice's noon the zenith angle is latitude minus 23.44 deg, refraction below 0.01 deg.
TEST(Sun, CulminatesSouthAtLatitudeMinusObliquityAtTheJuneSolstice) {
  const Site asuka{"Asuka", 34.47, 135.82, 134.0};
  SunPosition highest{{kPi}, {0.0}, {}};
  for (int minute = 0; minute < 120; ++minute) {
    const SunPosition sun = sun_position(at(2026, 6, 21, 2, minute % 60, 0) + hours{minute / 60}, asuka);
    if (sun.zenith < highest.zenith) highest = sun;
  }
  EXPECT_NEAR(to_degrees(highest.zenith), 34.47 - 23.44, 0.02);
  EXPECT_NEAR(to_degrees(highest.azimuth), 180.0, 1.5);
}

// The equinox of 2024-03-20 03:06 UTC: declination 0, so a sun on the equator's meridian passes the zenith.
TEST(Sun, StandsAtTheZenithOfTheSubsolarPointAtTheEquinox) {
  double lowest = 180.0;
  for (double longitude = 120.0; longitude < 150.0; longitude += 0.01)
    lowest = std::min(lowest, to_degrees(sun_position(at(2024, 3, 20, 3, 6, 0), {"", 0.0, longitude, 0.0}).zenith));
  EXPECT_LT(lowest, 0.01);
}

// Bennett's formula gives 28.98 arc minutes at the horizon, 5.31 at 10 deg, for 1010 hPa and 10 C.
TEST(Sun, IsLiftedByRefraction) {
  const Site site{"", 34.47, 135.82, 0.0};
  const SurfaceWeather air{1010.0, 10.0, 0.0}, nothing{0.0, 10.0, 0.0};
  Utc utc = at(2026, 6, 21, 3, 0, 0);
  while (to_degrees(sun_position(utc, site, nothing).zenith) < 80.0) utc += seconds{20};
  const double lift =
      to_degrees(sun_position(utc, site, nothing).zenith) - to_degrees(sun_position(utc, site, air).zenith);
  EXPECT_NEAR(lift * 60.0, 5.31, 0.1);
}

TEST(Sun, LowersItsRefractionOnAMountain) {
  EXPECT_NEAR(standard_air(0.0).pressure_hpa, 1013.25, 0.01);
  EXPECT_NEAR(standard_air(5000.0).pressure_hpa, 540.2, 0.5);  // international standard atmosphere
  EXPECT_NEAR(standard_air(5000.0).temperature_c, -17.5, 0.01);
}

TEST(Sun, IsComputedForClocksThatStandAt1970OrBeyondTheLeapSecondTable) {
  for (const Utc utc : {at(1970, 1, 1, 0, 0, 10), at(2100, 7, 1, 12, 0, 0)}) {
    const SunPosition sun = sun_position(utc, {"", 47.0, 8.0, 400.0});
    EXPECT_TRUE(std::isfinite(sun.zenith.value) && std::isfinite(sun.azimuth.value));
    EXPECT_NEAR(glm::length(sun.direction), 1.0, 1e-12);
  }
}

}  // namespace
}  // namespace kasumi
