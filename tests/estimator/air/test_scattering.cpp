#include <cmath>

#include <gtest/gtest.h>

#include "estimator/air/scattering.hpp"

namespace kasumi {
namespace {

using enum ScatteringModel;

TEST(Scattering, RayleighAt550nmIsEq3TimesItsCorrection) {
  EXPECT_NEAR(rayleigh_per_m(preetham, 550.0) * 1e3, .0135629, 1e-7);  // 1/km, recomputed from M Eq 3
  EXPECT_NEAR(rayleigh_per_m(morales2017, 550.0) * 1e3, .0141, 1e-6);  // M Table 2
}

TEST(Scattering, RayleighFallsWithTheFourthPowerOfWavelength) {
  EXPECT_NEAR(rayleigh_per_m(morales2017, 400.0) / rayleigh_per_m(morales2017, 800.0), 16.0, 1e-12);
}

TEST(Scattering, MieFallsWithTheSquareOfWavelength) {
  EXPECT_NEAR(mie_per_m(morales2017, 400.0, Turbidity{3.0}) / mie_per_m(morales2017, 800.0, Turbidity{3.0}), 4.0,
              1e-12);
}

TEST(Scattering, BothFallByEOverTheirScaleHeight) {
  EXPECT_NEAR(rayleigh_per_m(morales2017, 550.0, 7994.0) / rayleigh_per_m(morales2017, 550.0), std::exp(-1.0), 1e-12);
  EXPECT_NEAR(mie_per_m(morales2017, 550.0, Turbidity{3.0}, 1200.0) / mie_per_m(morales2017, 550.0, Turbidity{3.0}),
              std::exp(-1.0), 1e-12);
}

TEST(Scattering, MieFitsTheTableOfWeatherConditionsThroughEq24) {
  EXPECT_NEAR(mie_per_m(morales2017, 550.0, Turbidity{1.6}) * 1e3, .063845, 1e-6);
  for (const double limit_per_km : {.0639, .1819, .3769, .9399, 1.9459}) {  // M Table 2
    const Turbidity turbidity{1.0 + 0.6 * limit_per_km / .0639};            // M Eq 24 from T = 1.6
    EXPECT_NEAR(mie_per_m(morales2017, 550.0, turbidity) * 1e3 / limit_per_km, 1.0, 1e-3);
  }
}

TEST(Scattering, PureAirHasNoMieScatteringAndLessThanPureAirNone) {
  for (const auto model : {morales2017, preetham, zhao}) {
    EXPECT_GE(mie_per_m(model, 550.0, Turbidity{1.0}), 0.0);
    EXPECT_EQ(mie_per_m(model, 550.0, Turbidity{0.9}), 0.0);
  }
  EXPECT_EQ(mie_per_m(morales2017, 550.0, Turbidity{1.0}), 0.0);
}

TEST(Scattering, ZhaoIsAHundredthOfPreethamAndOursIs35PercentAboveZhao) {
  const Turbidity t{3.0};
  EXPECT_NEAR(mie_per_m(preetham, 550.0, t) / mie_per_m(zhao, 550.0, t), 100.0, 1e-9);
  EXPECT_NEAR(mie_per_m(morales2017, 550.0, t) / mie_per_m(zhao, 550.0, t), 1.35, 0.01);
}

TEST(Scattering, PreethamsFudgeFactorRunsFromItsTablesFirstToItsLast) {
  EXPECT_DOUBLE_EQ(preetham_fudge_factor(380.0), 0.650393);
  EXPECT_DOUBLE_EQ(preetham_fudge_factor(550.0), 0.677739);
  EXPECT_DOUBLE_EQ(preetham_fudge_factor(780.0), 0.689449);
  EXPECT_NEAR(preetham_fudge_factor(385.0), (0.650393 + 0.653435) / 2.0, 1e-12);
  EXPECT_DOUBLE_EQ(preetham_fudge_factor(300.0), 0.650393);
  EXPECT_DOUBLE_EQ(preetham_fudge_factor(900.0), 0.689449);
}

TEST(Scattering, ModelsAreFoundByTheirNames) {
  for (const auto model : {morales2017, preetham, zhao}) EXPECT_EQ(scattering_model_named(name_of(model)), model);
  EXPECT_FALSE(scattering_model_named("nishita"));
}

TEST(Weather, MeteorologicalRangeIsKoschmiedersAt550nm) {
  EXPECT_NEAR(air_quality(Turbidity{1.0}, 0.0).visibility_m, 277e3, 1e3);   // International Visibility Code: pure air
  EXPECT_NEAR(air_quality(Turbidity{1.9}, 0.0).visibility_m, 35.6e3, 100);  // M14 says 20 km, which is T = 2.71
  EXPECT_NEAR(air_quality(Turbidity{2.71}, 0.0).visibility_m, 20.0e3, 100);
}

TEST(Weather, AerosolOpticalDepthGrowsByATenthPerUnitOfTurbidity) {
  EXPECT_NEAR(air_quality(Turbidity{4.0}, 0.0).aod_550 - air_quality(Turbidity{3.0}, 0.0).aod_550, .1003, 1e-4);
  EXPECT_NEAR(air_quality(Turbidity{2.0}, 0.0).aod_550, .1006, 5e-4);
}

TEST(Weather, ClassesChangeAtTheTablesLimits) {
  EXPECT_EQ(weather_class(0.0), WeatherClass::pure_air);
  EXPECT_EQ(weather_class(.0638e-3), WeatherClass::exceptionally_clear);
  EXPECT_EQ(weather_class(.0640e-3), WeatherClass::very_clear);
  EXPECT_EQ(weather_class(.1820e-3), WeatherClass::clear);
  EXPECT_EQ(weather_class(.3770e-3), WeatherClass::light_haze);
  EXPECT_EQ(weather_class(.9400e-3), WeatherClass::haze);
  EXPECT_EQ(weather_class(1.946e-3), WeatherClass::fog);
  EXPECT_EQ(air_quality(Turbidity{1.6}, 0.0).weather, WeatherClass::exceptionally_clear);
  EXPECT_EQ(air_quality(Turbidity{4.0}, 0.0).weather, WeatherClass::clear);
  EXPECT_EQ(name_of(WeatherClass::light_haze), "light haze");
}

TEST(Weather, AMountainSeesFartherThroughTheSameTurbidity) {
  EXPECT_GT(air_quality(Turbidity{4.0}, 1500.0).visibility_m, 2.5 * air_quality(Turbidity{4.0}, 0.0).visibility_m);
}

TEST(Weather, AirNearTheGroundThickensThePathAndNotTheColumn) {
  const Aerosol column{0.2, 1.0, AerosolKind::continental};
  const AirState usual(column), thick = usual.with_near_ground(3.0);
  EXPECT_EQ(AirState(column, {}, 1.0), usual);
  EXPECT_EQ(AirState(column, {}, 3.0), thick);
  for (const double nm : {450.0, 550.0, 650.0})
    for (const double altitude_m : {0.0, 1500.0}) {
      EXPECT_DOUBLE_EQ(mie_per_m(aerosol, nm, thick, altitude_m), 3.0 * mie_per_m(aerosol, nm, usual, altitude_m));
      EXPECT_DOUBLE_EQ(mie_per_m(morales2017, nm, thick, altitude_m),
                       3.0 * mie_per_m(morales2017, nm, usual, altitude_m));
    }
  const AirQuality quality = air_quality(thick, 0.0), without = air_quality(usual, 0.0);
  EXPECT_EQ(quality.aod_550, without.aod_550);
  EXPECT_EQ(quality.turbidity, without.turbidity);
  const double molecules = rayleigh_per_m(aerosol, 550.0), haze = mie_per_m(aerosol, 550.0, usual);
  EXPECT_NEAR(quality.visibility_m, 3.912 / (molecules + 3.0 * haze), 1e-6);
  EXPECT_GT(quality.weather, without.weather);  // the class is of the air around the visitor
}

}  // namespace
}  // namespace kasumi
