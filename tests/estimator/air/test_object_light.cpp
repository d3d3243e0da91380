#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "calib/colorimetry.hpp"
#include "estimator/object_light.hpp"

namespace kasumi {
namespace {

Direction at_deg(double zenith, double azimuth) {
  return direction_from(from_degrees(zenith), from_degrees(azimuth));
}
const Direction kUp{0.0, 0.0, 1.0};

Camera srgb_camera() {
  Camera camera;
  camera.colour_space = Camera::ColourSpace::srgb;
  return camera;
}
Camera sensor_camera() {
  Camera camera;
  camera.colour_space = Camera::ColourSpace::sensor;
  return camera;
}

// Irradiance by brute force: radiance times cosine over a fine grid of the whole sphere.
glm::dvec3 brute_force(const std::function<glm::dvec3(const Direction&)>& radiance, const Direction& normal) {
  constexpr int kZeniths = 600, kAzimuths = 600;
  glm::dvec3 sum{0.0};
  for (int i = 0; i < kZeniths; ++i) {
    const double zenith = (i + 0.5) * kPi / kZeniths;
    for (int j = 0; j < kAzimuths; ++j) {
      const Direction direction = direction_from({zenith}, {(j + 0.5) * 2.0 * kPi / kAzimuths});
      const double cosine = glm::dot(direction, normal);
      if (cosine <= 0.0) continue;
      sum += radiance(direction) * (cosine * std::sin(zenith) * (kPi / kZeniths) * (2.0 * kPi / kAzimuths));
    }
  }
  return sum;
}

TEST(AirMass, IsKastenAndYoungsTable) {
  EXPECT_NEAR(air_mass(from_degrees(0.0)), 1.0, 1e-3);
  EXPECT_NEAR(air_mass(from_degrees(60.0)), 1.994, 1e-3);
  EXPECT_NEAR(air_mass(from_degrees(80.0)), 5.586, 2e-2);
  EXPECT_NEAR(air_mass(from_degrees(90.0)), 38.0, 0.2);
}

TEST(Sunlight, AboveTheAtmosphereIs128KiloluxAndVisiblePowerNear46Percent) {
  double lux = 0.0, power = 0.0;
  for (int nm = 380; nm <= 780; ++nm) {
    lux += 683.0 * solar_irradiance(nm) * colour_matching(nm).y;
    power += solar_irradiance(nm);
  }
  fmt::print("illuminance above the atmosphere {:.1f} klx, visible power {:.0f} W/m2\n", lux / 1e3, power);
  EXPECT_NEAR(lux, 128e3, 6e3);  // IES: 127.5 klx; Kittler and Darula: 133.3 klx
  EXPECT_NEAR(power / 1366.1, 0.455, 0.02);
}

TEST(Sunlight, ThroughCleanAirIsRayleighAndOzoneAlone) {
  // At 550 nm Bucholtz has .0972 for Rayleigh (Preetham's fit .1001); ozone .35 cm x .085 / cm; T = 1 leaves no
  // aerosol.
  const double transmittance = sun_transmittance(Turbidity{1.0}, from_degrees(0.0), 0.0, 550.0);
  EXPECT_NEAR(-std::log(transmittance), .0972 + .0298, 4e-3);
}

TEST(Sunlight, FallsThroughMoreAirAndMoreHaze) {
  const auto at = [](double t, double zenith) {
    return sun_transmittance(Turbidity{t}, from_degrees(zenith), 0.0, 550.0);
  };
  EXPECT_GT(at(2.0, 30.0), at(2.0, 70.0));
  EXPECT_GT(at(2.0, 30.0), at(4.0, 30.0));
  EXPECT_GT(sun_transmittance(Turbidity{2.0}, from_degrees(60.0), 3000.0, 400.0),
            sun_transmittance(Turbidity{2.0}, from_degrees(60.0), 0.0, 400.0));
}

TEST(Harmonics, AnEvenSkyGivesPiLFromAboveHalfOfItFromTheSideAndNothingFromBelow) {
  const auto harmonics = sky_harmonics([](const Direction&) { return glm::dvec3{1.0, 2.0, 3.0}; });
  EXPECT_NEAR(irradiance(harmonics, kUp).x, kPi, 1e-3);
  EXPECT_NEAR(irradiance(harmonics, kUp).z, 3.0 * kPi, 3e-3);
  EXPECT_NEAR(irradiance(harmonics, at_deg(90.0, 77.0)).x, kPi / 2.0, 1e-3);
  EXPECT_NEAR(irradiance(harmonics, -kUp).x, 0.0, 1e-3);
}

TEST(Harmonics, AnEvenSkyOverAnEvenGroundLightsAllSidesAlike) {
  auto harmonics = sky_harmonics([](const Direction&) { return glm::dvec3{1.0}; });
  const auto ground = ground_harmonics(glm::dvec3{1.0});
  for (std::size_t i = 0; i < harmonics.size(); ++i) harmonics[i] += ground[i];
  for (double zenith = 0.0; zenith <= 180.0; zenith += 15.0) {
    for (double azimuth = 0.0; azimuth < 360.0; azimuth += 45.0) {
      EXPECT_NEAR(irradiance(harmonics, at_deg(zenith, azimuth)).y, kPi, 1e-3);
    }
  }
}

TEST(Harmonics, ASkyBrighterInTheEastIsExactToSecondOrder) {
  // A sky of degree 2 whose other half is dark keeps some of its light in degrees above 2: within 3 % of brute force.
  const auto radiance = [](const Direction& d) {
    return d.z > 0.0 ? glm::dvec3{1.0 + 0.8 * d.x + 0.3 * d.x * d.y} : glm::dvec3{0.0};
  };
  const auto harmonics = sky_harmonics(radiance);
  for (const Direction& normal : {kUp, at_deg(90.0, 90.0), at_deg(90.0, 270.0), at_deg(45.0, 30.0)}) {
    EXPECT_NEAR(irradiance(harmonics, normal).x, brute_force(radiance, normal).x, 0.03 * kPi);
  }
}

TEST(Daylight, SkyAndGroundOnWallsAndRoofsAreThoseOfBruteForce) {
  for (const double t : {2.0, 4.0, 8.0}) {
    DaylightOptions options;
    const Daylight daylight(srgb_camera(), Turbidity{t}, at_deg(50.0, 200.0), options);
    const auto& light = daylight.on_object();
    const auto sky = [&](const Direction& d) { return d.z > 0.0 ? daylight.airlight(d) : glm::dvec3{0.0}; };
    const glm::dvec3 on_ground = brute_force(sky, kUp) + std::cos(from_degrees(50.0).value) * light.sun_irradiance;
    const glm::dvec3 ground = options.ground_albedo / kPi * on_ground;
    const auto all = [&](const Direction& d) { return d.z > 0.0 ? daylight.airlight(d) : ground; };
    const glm::dvec3 open = irradiance(light.sky_irradiance_sh, kUp);
    double worst = 0.0;
    for (const Direction& normal :
         {kUp, at_deg(90.0, 200.0), at_deg(90.0, 20.0), at_deg(90.0, 110.0), at_deg(45.0, 200.0), at_deg(45.0, 20.0)}) {
      const glm::dvec3 truth = brute_force(all, normal), found = irradiance(light.sky_irradiance_sh, normal);
      for (int c = 0; c < 3; ++c) worst = std::max(worst, std::abs(found[c] - truth[c]) / open[c]);
    }
    fmt::print("T {}: order 2 keeps within {:.1f} % of the open sky's irradiance\n", t, 100.0 * worst);
    EXPECT_LE(worst, 0.06);
  }
}

TEST(Daylight, SunAndSkyAreAsBrightAsMeasurementsSay) {
  for (const double t : {2.0, 2.5, 3.0, 4.0, 6.0}) {
    const Daylight m12(srgb_camera(), Turbidity{t}, at_deg(33.6, 180.0));
    const Daylight low(srgb_camera(), Turbidity{t}, at_deg(75.0, 180.0));
    fmt::print(
        "T {}: air mass {:.2f} sun {:.1f} klx, diffuse {:.1f} klx; air mass {:.2f} sun {:.1f} klx, diffuse {:.1f} "
        "klx\n",
        t, air_mass(from_degrees(33.6)), m12.sun_normal_lux() / 1e3, m12.sky_horizontal_lux() / 1e3,
        air_mass(from_degrees(75.0)), low.sun_normal_lux() / 1e3, low.sky_horizontal_lux() / 1e3);
  }
  const Daylight clear(srgb_camera(), Turbidity{2.5}, at_deg(33.6, 180.0));
  EXPECT_NEAR(clear.sun_normal_lux(), 100e3, 10e3);
  // Measured clear skies give 10-20 klx. Preetham's is half as much again: its direct and diffuse light together exceed
  // what air lets through. Kept, because the ratio of sky to horizon matters here and the horizon is of the same model.
  EXPECT_GT(clear.sky_horizontal_lux(), 10e3);
  EXPECT_LT(clear.sky_horizontal_lux(), 30e3);
}

TEST(Daylight, AnOvercastSkyIsCiesWithoutSunAndWhiteIsOneAt683Candela) {
  DaylightOptions options;
  options.sky = SkyCondition::overcast;
  const double zenith_deg = 40.0;
  const Daylight daylight(srgb_camera(), Turbidity{5.0}, at_deg(zenith_deg, 10.0), options);
  EXPECT_EQ(daylight.on_object().sun_irradiance, glm::dvec3{0.0});
  const double zenith = 123.0 + 8600.0 * std::cos(from_degrees(zenith_deg).value);
  const glm::dvec3 up = daylight.airlight(kUp), horizon = daylight.airlight(at_deg(90.0, 123.0));
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(up[c], zenith / 683.0, 1e-3 * zenith / 683.0);  // D65 is sRGB's white
    EXPECT_NEAR(horizon[c], up[c] / 3.0, 1e-9);
  }
  const double closed_form = 7.0 * kPi / 9.0 * zenith;
  EXPECT_NEAR(daylight.sky_horizontal_lux(), closed_form, 6e-3 * closed_form);  // order 2 leaves out .4 %
}

TEST(Daylight, ASensorSeesTheDaylightOfTheSkysChromaticity) {
  const SunDirection sun = at_deg(45.0, 100.0);
  const Camera camera = sensor_camera();
  const Daylight daylight(camera, Turbidity{3.0}, sun);
  const Direction view = at_deg(85.0, 40.0);
  const glm::dvec3 Yxy = SkyModel(Turbidity{3.0}, sun).luminance_and_chromaticity(view);
  double luminance = 0.0;
  glm::dvec3 channels{0.0};
  for (int nm = 380; nm <= 780; ++nm) {
    const double power = daylight_spectrum(Yxy.y, Yxy.z, nm);
    luminance += 683.0 * power * colour_matching(nm).y;
    channels += power * camera.sensitivity.at(nm);
  }
  channels *= 1000.0 * Yxy.x / luminance;
  const glm::dvec3 found = daylight.airlight(view);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c] / channels[c], 1.0, 2e-3);
}

TEST(Daylight, BothColourSpacesTellTheSameSunThroughTheCamerasMatrix) {
  const SunDirection sun = at_deg(45.0, 100.0);
  const Camera camera = sensor_camera();
  const Daylight sensor(camera, Turbidity{3.0}, sun), srgb(srgb_camera(), Turbidity{3.0}, sun);
  const glm::dmat3 mix = glm::inverse(srgb_to_xyz()) * camera_to_xyz(camera.sensitivity);
  const Direction view = at_deg(80.0, 40.0);
  const glm::dvec3 sky = (mix * sensor.airlight(view)) / srgb.airlight(view);
  const glm::dvec3 direct = (mix * sensor.on_object().sun_irradiance) / srgb.on_object().sun_irradiance;
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(sky[c] / sky.y, 1.0, 1e-6);
    EXPECT_NEAR(direct[c] / sky.y, 1.0, 1e-6);
  }
}

TEST(Daylight, TheSunSetsAcrossItsDiscAndLeavesTheSky) {
  const auto sun_at = [](double zenith) {
    return Daylight(srgb_camera(), Turbidity{2.0}, at_deg(zenith, 0.0)).on_object().sun_irradiance;
  };
  EXPECT_GT(sun_at(89.7).x, sun_at(89.95).x);
  EXPECT_GT(sun_at(89.95).x, 0.0);
  EXPECT_EQ(sun_at(90.3), glm::dvec3{0.0});
  EXPECT_GT(sun_at(85.0).x, 2.0 * sun_at(85.0).z);  // red
}

TEST(Daylight, IsPositiveAndFiniteForEveryTurbidityAndSun) {
  for (const double t : {1.0, 1.7, 2.0, 5.0, 12.0, 20.0, 40.0}) {
    for (const double zenith : {0.0, 30.0, 60.0, 80.0, 87.0, 89.9, 91.0, 100.0, 170.0}) {
      for (const auto sky : {SkyCondition::clear, SkyCondition::overcast}) {
        DaylightOptions options;
        options.sky = sky;
        const Daylight daylight(srgb_camera(), Turbidity{t}, at_deg(zenith, 30.0), options);
        for (const Direction& view : {kUp, at_deg(90.0, 30.0), at_deg(95.0, 200.0), at_deg(zenith, 30.0), -kUp}) {
          const glm::dvec3 light = daylight.airlight(view);
          for (int c = 0; c < 3; ++c) ASSERT_TRUE(std::isfinite(light[c]) && light[c] > 0.0) << t << " " << zenith;
        }
        for (const Direction& normal : {kUp, at_deg(90.0, 30.0), at_deg(90.0, 210.0)}) {
          const glm::dvec3 received = irradiance(daylight.on_object().sky_irradiance_sh, normal);
          for (int c = 0; c < 3; ++c)
            ASSERT_TRUE(std::isfinite(received[c]) && received[c] > 0.0) << t << " " << zenith;
        }
      }
    }
  }
}

TEST(Daylight, AWhiteWallNearHazeAtInfinityIsOfTheHorizonsOrder) {
  // What rho = L0 / Linf means for a visitor: a sunlit white wall outshines the clear horizon away from the sun, a dark
  // one does not.
  const Daylight daylight(srgb_camera(), Turbidity{3.0}, at_deg(50.0, 180.0));
  const Direction wall = at_deg(90.0, 180.0);  // faces the sun
  const glm::dvec3 received = irradiance(daylight.on_object().sky_irradiance_sh, wall) +
                              std::sin(from_degrees(50.0).value) * daylight.on_object().sun_irradiance;
  const glm::dvec3 horizon = daylight.airlight(at_deg(90.0, 0.0));
  fmt::print("rho of a white wall in the sun: {:.2f} {:.2f} {:.2f}\n", received.x / kPi / horizon.x,
             received.y / kPi / horizon.y, received.z / kPi / horizon.z);
  EXPECT_GT(received.y / kPi, horizon.y);
  EXPECT_LT(0.05 * received.y / kPi, horizon.y);
}

}  // namespace
}  // namespace kasumi
