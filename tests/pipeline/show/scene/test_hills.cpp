#include <gtest/gtest.h>

#include "pipeline/show/scene/scene_air.hpp"

namespace kasumi {
namespace {

SkyReport under_sun(double elevation_deg) {
  SkyReport report;
  report.sun.source = SunSource::ephemeris;
  report.sun.direction = direction_from(from_degrees(90.0 - elevation_deg), from_degrees(240.0));
  return report;
}

TEST(Hills, TakeTheSunFromTheObjectAlone) {
  Installation installation;
  const SceneAir open(installation, {});
  installation.object.skyline = Skyline({{0.0, 20.0}, {180.0, 20.0}});
  const SceneAir valley(installation, {});
  for (const double elevation_deg : {10.0, 19.0, 20.0, 21.0, 40.0}) {
    const auto past_hills = valley.conditions(under_sun(elevation_deg)).past_hills;
    EXPECT_NEAR(past_hills, elevation_deg < 20.0 ? 0.0 : elevation_deg > 20.0 ? 1.0 : 0.5, 1e-9) << elevation_deg;
    EXPECT_EQ(open.conditions(under_sun(elevation_deg)).past_hills, 1.0);
  }

  const auto evening = valley.conditions(under_sun(10.0)), before = open.conditions(under_sun(10.0));
  const auto light_under = [](const SceneConditions& conditions) {
    return Daylight({}, conditions.air, conditions.sun, {.past_hills = conditions.past_hills}).on_object();
  };
  const auto shaded = light_under(evening), lit = light_under(before);
  EXPECT_EQ(shaded.sun_irradiance.g, 0.0);
  EXPECT_GT(lit.sun_irradiance.g, 0.0);
  const Direction up{0.0, 0.0, 1.0};
  EXPECT_NEAR(irradiance(shaded.around, up).g / irradiance(lit.around, up).g, 1.0, 1e-3) << "the sky's light stays";
}

TEST(Hills, AreDrawnAnewAsTheSunGoesDownBehindThem) {
  Installation installation;
  installation.object.skyline = Skyline({{0.0, 20.0}, {180.0, 20.0}});
  const SceneAir valley(installation, {});
  const auto whole = valley.conditions(under_sun(20.27)), almost = valley.conditions(under_sun(20.25));
  const auto less = valley.conditions(under_sun(20.20));
  EXPECT_TRUE(look_alike(whole, almost)) << almost.past_hills;
  EXPECT_FALSE(look_alike(whole, less)) << less.past_hills;
}

}  // namespace
}  // namespace kasumi
