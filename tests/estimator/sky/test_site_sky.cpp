#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <glm/matrix.hpp>

#include "calib/colour/colorimetry.hpp"
#include "estimator/light/airlight.hpp"
#include "estimator/light/object_light.hpp"
#include "estimator/sky/site_sky.hpp"

namespace kasumi {
namespace {

Direction at_deg(double zenith_deg, double azimuth_deg) {
  return direction_from(from_degrees(zenith_deg), from_degrees(azimuth_deg));
}

glm::dvec2 chromaticity(const glm::dvec3& xyz) {
  return glm::dvec2(xyz) / (xyz.x + xyz.y + xyz.z);
}

TEST(SiteSky, IsPreethamsOnLowLandToTheLastBit) {
  const SunDirection sun = at_deg(50.0, 120.0);
  const PreethamSky model(Turbidity{2.9}, sun);
  const SiteSky sky(DaylightModel::automatic, Turbidity{2.9}, sun, kHighestPreethamSite_m);
  EXPECT_FALSE(sky.zenith_cd_m2());
  for (const double zenith : {0.0, 40.0, 80.0, 89.0})
    EXPECT_EQ(sky.relative_xyz(at_deg(zenith, 30.0)), model.relative_xyz(at_deg(zenith, 30.0)));
}

TEST(SiteSky, TheModelIsTheOneAskedForWhateverTheAltitude) {
  const SunDirection sun = at_deg(50.0, 120.0);
  EXPECT_TRUE(SiteSky(DaylightModel::dome, Turbidity{2.9}, sun, 0.0).zenith_cd_m2());
  EXPECT_FALSE(SiteSky(DaylightModel::preetham, Turbidity{2.9}, sun, 4000.0).zenith_cd_m2());
  EXPECT_TRUE(SiteSky(DaylightModel::automatic, Turbidity{2.9}, sun, 4000.0).zenith_cd_m2());
}

TEST(SiteSky, AKnownAerosolIsTheDomes) {
  const SunDirection sun = at_deg(50.0, 120.0);
  const Aerosol dust{0.5, -0.1, AerosolKind::dust};
  const SiteSky sky(DaylightModel::automatic, dust, sun, 100.0);
  EXPECT_EQ(sky.dome_share(), 1.0);
  const auto truth = dome(100.0, dust, sun);
  const Direction view = at_deg(70.0, 30.0);
  const glm::dvec3 light = *sky.zenith_cd_m2() * sky.relative_xyz(view), expected = dome_light(truth, view);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(light[c] / expected[c], 1.0, 1e-9);
  EXPECT_EQ(SiteSky(DaylightModel::preetham, dust, sun, 100.0).dome_share(), 0.0) << "asked for";
}

TEST(SiteSky, UnderALowSunLowLandsSkyFadesIntoTheDomeWithoutAJump) {
  Camera camera;
  camera.colour_space = Camera::ColourSpace::srgb;
  const Direction view = at_deg(75.0, 60.0);
  double before = 0.0;
  glm::dvec3 light_before{0.0};
  for (double elevation = 10.0; elevation <= 18.0; elevation += 0.1) {
    const SunDirection sun = at_deg(90.0 - elevation, 120.0);
    const SiteSky sky(DaylightModel::automatic, Turbidity{2.8}, sun, 0.0);
    EXPECT_EQ(SiteSky(DaylightModel::preetham, Turbidity{2.8}, sun, 0.0).dome_share(), 0.0);
    if (elevation < 11.9) {
      EXPECT_EQ(sky.dome_share(), 1.0);
    }
    if (elevation > 16.1) {
      EXPECT_EQ(sky.dome_share(), 0.0);
    }
    const Daylight daylight(camera, Turbidity{2.8}, sun);
    const glm::dvec3 light = daylight.airlight(view) + daylight.on_object().sun_irradiance;
    for (int c = 0; c < 3 && before > 0.0; ++c) EXPECT_NEAR(light[c] / light_before[c], 1.0, 0.05) << elevation;
    before = elevation;
    light_before = light;
  }
}

TEST(SiteSky, NamesAreReadBack) {
  for (const auto model : {DaylightModel::automatic, DaylightModel::preetham, DaylightModel::dome})
    EXPECT_EQ(daylight_model_named(name_of(model)), model);
  EXPECT_FALSE(daylight_model_named("hosek"));
}

TEST(SiteSky, HigherUpTheZenithDarkensAndTurnsABlueOfAirAlone) {
  const SunDirection sun = at_deg(45.0, 180.0);
  double before = 1e9, before_y = 1.0;
  for (const double altitude_m : {0.0, 2000.0, 4000.0, 6000.0}) {
    const SiteSky sky(DaylightModel::dome, Turbidity{3.0}, sun, altitude_m);
    const double zenith = *sky.zenith_cd_m2(), y = chromaticity(sky.relative_xyz({0.0, 0.0, 1.0})).y;
    EXPECT_LT(zenith, before) << altitude_m;
    EXPECT_LT(y, before_y) << altitude_m;
    before = zenith;
    before_y = y;
  }
}

// Two independent computations: SPCTRAL2's sums (which scale Preetham's distribution), and the fitted shells, for the
// same aerosol.
TEST(SiteSky, TheDomeLightsTheGroundAsSpctral2Has) {
  for (const double turbidity : {2.5, 4.0})
    for (const double sun_zenith_deg : {25.0, 50.0, 70.0}) {
      const SunDirection sun = at_deg(sun_zenith_deg, 200.0);
      const DomeFunction sky = dome(0.0, Turbidity{turbidity}, sun);
      double lux = 0.0;
      constexpr int kRings = 60, kSectors = 72;
      for (int ring = 0; ring < kRings; ++ring)  // uniform steps of cos^2 have equal weight on the ground
        for (int sector = 0; sector < kSectors; ++sector)
          lux += dome_light(sky, direction_from(Radians{std::acos(std::sqrt((ring + 0.5) / kRings))},
                                                Radians{2.0 * kPi * (sector + 0.5) / kSectors}))
                     .y *
                 kPi / (kRings * kSectors);
      const double spctral2 = clear_sky_lux(Turbidity{turbidity}, from_degrees(sun_zenith_deg), 0.0, 0.2);
      fmt::print("T {}, sun {} deg: {:.0f} of {:.0f} lx\n", turbidity, sun_zenith_deg, lux, spctral2);
      EXPECT_NEAR(lux / spctral2, 1.0, 0.15) << turbidity << " " << sun_zenith_deg;
    }
}

TEST(SiteSky, AHighSitesObjectIsLitByTheDome) {
  Camera camera;
  camera.colour_space = Camera::ColourSpace::srgb;
  DaylightConditions options;
  options.altitude_m = 3000.0;
  const SunDirection sun = at_deg(45.0, 200.0);
  const Daylight high(camera, Turbidity{2.1}, sun, options);
  options.model = DaylightModel::preetham;
  const Daylight as_on_low_land(camera, Turbidity{2.1}, sun, options);
  // With less air above there is more sunlight and less skylight, and the zenith is a purer blue.
  EXPECT_GT(high.sun_normal_lux(), 100e3);
  EXPECT_LT(high.sky_horizontal_lux(), as_on_low_land.sky_horizontal_lux());
  const auto saturation = [](const Daylight& light) {
    const glm::dvec3 zenith = light.airlight({0.0, 0.0, 1.0});
    return zenith.b / zenith.r;
  };
  EXPECT_GT(saturation(high), saturation(as_on_low_land));
}

TEST(SiteSky, CarriesAMeasuredHorizonUpAsTheDomeGoes) {
  const SunDirection sun = at_deg(50.0, 200.0);
  const SiteSky sky(DaylightModel::dome, Turbidity{2.5}, sun, 3000.0);
  const glm::dmat3 to_srgb = glm::inverse(srgb_to_xyz());
  HorizonLight horizon;
  horizon.source = HorizonLight::Source::scene_camera;
  const Direction reference = at_deg(85.0, 10.0), view = at_deg(70.0, 10.0);
  const double gain = 3e-3;
  horizon.columns.push_back(
      {from_degrees(10.0), from_degrees(85.0), gain * (to_srgb * sky.relative_xyz(reference)), 1.0});
  const Airlight airlight(horizon, sky, srgb_to_xyz());
  const glm::dvec3 expected = gain * (to_srgb * sky.relative_xyz(view)), found = airlight.from(view);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], expected[c], 1e-9 * expected[c] + 1e-15);
}

}  // namespace
}  // namespace kasumi
