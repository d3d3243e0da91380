#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "calib/colour/colorimetry.hpp"
#include "estimator/air/scattering.hpp"
#include "estimator/light/object_light.hpp"
#include "tests/estimator/light/at_deg.hpp"

namespace kasumi {
namespace {

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

// The upper hemisphere in fine cones: direction, radiance times solid angle.
struct Cone {
  Direction direction;
  glm::dvec3 power;
};
std::vector<Cone> cones_of(const std::function<glm::dvec3(const Direction&)>& radiance) {
  constexpr int kZeniths = 120, kAzimuths = 120;
  std::vector<Cone> cones;
  for (int i = 0; i < kZeniths; ++i) {
    const double zenith = (i + 0.5) * 0.5 * kPi / kZeniths;
    const double solid_angle = std::sin(zenith) * (0.5 * kPi / kZeniths) * (2.0 * kPi / kAzimuths);
    for (int j = 0; j < kAzimuths; ++j) {
      const Direction direction = direction_from({zenith}, {(j + 0.5) * 2.0 * kPi / kAzimuths});
      cones.push_back({direction, solid_angle * radiance(direction)});
    }
  }
  return cones;
}
glm::dvec3 gathered(const std::vector<Cone>& sky, const Direction& normal) {
  glm::dvec3 sum{0.0};
  for (const Cone& cone : sky) sum += std::max(0.0, glm::dot(cone.direction, normal)) * cone.power;
  return sum;
}

TEST(Daylight, AGreySphereIsLitAsByBruteForceOverSunSkyAndGround) {
  // All sides of it in each channel: the sunlit side, the shaded side, the one facing the horizon, the underside.
  for (const double t : {2.0, 2.6, 4.0, 8.0})
    for (const double sun_zenith : {20.0, 45.0, 52.0, 60.0, 75.0, 81.0, 85.0}) {
      DaylightConditions options;
      const SunDirection sun = at_deg(sun_zenith, 200.0);
      const Daylight daylight(srgb_camera(), Turbidity{t}, sun, options);
      const auto& light = daylight.on_object();
      const auto sky = cones_of([&](const Direction& d) { return daylight.airlight(d); });
      const glm::dvec3 on_ground = gathered(sky, kUp) + sun.z * light.sun_irradiance;
      double worst = 0.0, mean = 0.0;
      int sides = 0;
      for (const double zenith : {0.0, 45.0, 90.0, 110.0, 150.0})
        for (const double azimuth : {200.0, 245.0, 20.0}) {
          const Direction normal = at_deg(zenith, azimuth);
          const glm::dvec3 direct = std::max(0.0, glm::dot(normal, sun)) * light.sun_irradiance;
          // Uniform ground of radiance L gives a side an irradiance of pi L times its view factor of the ground.
          const glm::dvec3 truth =
              direct + gathered(sky, normal) + 0.5 * (1.0 - normal.z) * options.ground_albedo * on_ground;
          const glm::dvec3 found = direct + irradiance(light.around, normal);
          for (int c = 0; c < 3; ++c) {
            const double error = std::abs(found[c] - truth[c]) / truth[c];
            worst = std::max(worst, error);
            mean += error;
            ++sides;
          }
        }
      fmt::print("T {} sun {}: worst {:.2f} % of the side's own light, mean {:.2f} %\n", t, sun_zenith, 100.0 * worst,
                 100.0 * mean / sides);
      EXPECT_LE(worst, 0.01) << "T " << t << ", sun " << sun_zenith;
    }
}

TEST(Daylight, TheSkyLightsTheLevelGroundAsTheClearSkyModelSays) {
  for (const double t : {2.0, 3.0, 6.0})
    for (const double zenith : {20.0, 50.0, 75.0}) {
      const Daylight daylight(srgb_camera(), Turbidity{t}, at_deg(zenith, 180.0), {.model = DaylightModel::preetham});
      const auto luminance = [&](const Direction& d) { return srgb_to_xyz() * (683.0 * daylight.airlight(d)); };
      const double expected = clear_sky_lux(Turbidity{t}, from_degrees(zenith), 0.0, 0.2);
      EXPECT_NEAR(gathered(cones_of(luminance), kUp).y / expected, 1.0, 5e-3) << t << " " << zenith;
    }
}

TEST(Daylight, TheHorizonIsWhatScatteringAirUnderThatSunAndSkyShines) {
  // The measured horizon scales everything, so its level relative to sun and sky matters most. Light from infinity is
  // the air's source function: sunlight times its phase function (Rayleigh and Henyey-Greenstein, asymmetry .65) plus
  // the mean light from sky and ground, times the scattering albedo. The Perez distribution was fitted to measured
  // skies.
  for (const double t : {2.0, 3.0, 4.0, 6.0})
    for (const double zenith : {30.0, 45.0, 60.0}) {
      const Daylight daylight(srgb_camera(), Turbidity{t}, at_deg(zenith, 180.0));
      const double air = rayleigh_per_m(ScatteringModel::morales2017, 550.0);
      const double haze = mie_per_m(ScatteringModel::morales2017, 550.0, Turbidity{t});
      const double sun = daylight.sun_normal_lux(), sky = clear_sky_lux(Turbidity{t}, from_degrees(zenith), 0.0, 0.2);
      const double ground = 0.2 * (sky + sun * std::cos(from_degrees(zenith).value));
      for (const double azimuth : {90.0, 0.0}) {  // at the side, away from the sun
        const Direction view = at_deg(89.0, azimuth);
        const double cosine = glm::dot(view, at_deg(zenith, 180.0));
        const double by_air = 3.0 / (16.0 * kPi) * (1.0 + cosine * cosine);
        const double by_haze = (1.0 - 0.65 * 0.65) / (4.0 * kPi * std::pow(1.0 + 0.65 * 0.65 - 1.3 * cosine, 1.5));
        const double phase = (air * by_air + haze * by_haze) / (air + haze);
        const double albedo = (air + 0.93 * haze) / (air + haze);
        const double source = albedo * (sun * phase + 0.5 * (sky + ground) / kPi);
        const double horizon = 683.0 * (srgb_to_xyz() * daylight.airlight(view)).y;
        fmt::print("T {} sun {} deg from the zenith, {} deg aside: horizon {:.1f} kcd/m2, source function {:.1f}\n", t,
                   zenith, 180.0 - azimuth, horizon / 1e3, source / 1e3);
        EXPECT_NEAR(std::log(horizon / source), 0.0, 0.5);
      }
    }
}

TEST(Daylight, AnOvercastSkyIsCiesWithoutSunAndWhiteIsOneAt683Candela) {
  DaylightConditions options;
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
  EXPECT_NEAR(daylight.sky_horizontal_lux(), closed_form, 2e-3 * closed_form);
}

TEST(Daylight, ASensorSeesTheDaylightOfTheSkysChromaticity) {
  const SunDirection sun = at_deg(45.0, 100.0);
  const Camera camera = sensor_camera();
  const Daylight daylight(camera, Turbidity{3.0}, sun);
  const Direction view = at_deg(85.0, 40.0);
  const glm::dvec3 Yxy = PreethamSky(Turbidity{3.0}, sun).luminance_and_chromaticity(view);
  double luminance = 0.0;
  glm::dvec3 channels{0.0};
  for (int nm = 380; nm <= 780; ++nm) {
    const double power = daylight_spectrum(Yxy.y, Yxy.z, nm);
    luminance += 683.0 * power * colour_matching(nm).y;
    channels += power * camera.sensitivity.at(nm);
  }
  channels *= 1000.0 * Yxy.x / luminance;
  const glm::dvec3 found = daylight.airlight(view);
  // As bright as the clear sky model says, not as Preetham's zenith.
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c] / channels[c] / (found.y / channels.y), 1.0, 2e-3);
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
        DaylightConditions options;
        options.sky = sky;
        const Daylight daylight(srgb_camera(), Turbidity{t}, at_deg(zenith, 30.0), options);
        for (const Direction& view : {kUp, at_deg(90.0, 30.0), at_deg(95.0, 200.0), at_deg(zenith, 30.0), -kUp}) {
          const glm::dvec3 light = daylight.airlight(view);
          for (int c = 0; c < 3; ++c) ASSERT_TRUE(std::isfinite(light[c]) && light[c] > 0.0) << t << " " << zenith;
        }
        for (const Direction& normal : {kUp, at_deg(90.0, 30.0), at_deg(90.0, 210.0)}) {
          const glm::dvec3 received = irradiance(daylight.on_object().around, normal);
          for (int c = 0; c < 3; ++c)
            ASSERT_TRUE(std::isfinite(received[c]) && received[c] > 0.0) << t << " " << zenith;
        }
      }
    }
  }
}

TEST(Daylight, AWhiteWallNearHazeAtInfinityIsOfTheHorizonsOrder) {
  // What rho = L0 / Linf means for a visitor: a sunlit white wall is brighter than the clear horizon away from the sun,
  // a dark one is not.
  const Daylight daylight(srgb_camera(), Turbidity{3.0}, at_deg(50.0, 180.0));
  const Direction wall = at_deg(90.0, 180.0);  // faces the sun
  const glm::dvec3 received = irradiance(daylight.on_object().around, wall) +
                              std::sin(from_degrees(50.0).value) * daylight.on_object().sun_irradiance;
  const glm::dvec3 horizon = daylight.airlight(at_deg(90.0, 0.0));
  fmt::print("rho of a white wall in the sun: {:.2f} {:.2f} {:.2f}\n", received.x / kPi / horizon.x,
             received.y / kPi / horizon.y, received.z / kPi / horizon.z);
  EXPECT_GT(received.y / kPi, horizon.y);
  EXPECT_LT(0.05 * received.y / kPi, horizon.y);
}

}  // namespace
}  // namespace kasumi
