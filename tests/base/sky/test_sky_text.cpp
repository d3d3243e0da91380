// The code that GPU and CPU share, against closed forms and numeric integrals.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include <glm/geometric.hpp>

#include "base/earth.hpp"
#include "base/sky/dome_scene.hpp"
#include "base/sky/sun_disc.hpp"

namespace kasumi {
namespace {

using sky_text::luminance_of;
using sky_text::tone_mapped;

// Colours from grey to far outside sRGB, at all intensities.
std::vector<glm::dvec3> many_lights() {
  std::mt19937_64 random(5);
  const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  std::vector<glm::dvec3> lights;
  while (lights.size() < 4000) {
    const glm::dvec3 light =
        std::pow(10.0, 9.0 * unit() - 2.0) * glm::dvec3(unit() * 1.4 - 0.4, unit(), unit() * 1.4 - 0.4);
    if (luminance_of(light) > 0.02 * glm::length(light)) lights.push_back(light);
  }
  return lights;
}

double shown_luminance(double exposed) {
  return 1.0 - std::pow(1.0 + exposed / 2.0, -2.0);
}

TEST(ToneMapping, RollsTheLuminanceOfEveryColourOff) {
  for (const auto& light : many_lights())
    EXPECT_NEAR(luminance_of(tone_mapped(light, 1e-4)), shown_luminance(1e-4 * luminance_of(light)), 1e-9);
}

// A tenth of CIE 146's veiling luminance for an eye: at 1 deg 15 cd/m2 per lux, at 10 deg .06.
TEST(SunGlare, IsATenthOfAnEyes) {
  const double lux = 1e5, luminance = lux / 6.797e-5;
  const auto at = [&](double degrees) {
    return sky_text::sun_glare(glm::dvec3(luminance), 2.0 * std::sin(0.5 * from_degrees(degrees).value)).g;
  };
  EXPECT_NEAR(at(1.0), 0.1 * 15.0 * lux, 0.001 * lux);
  EXPECT_NEAR(at(10.0), 0.1 * 0.06 * lux, 0.001 * 0.06 * lux);
  EXPECT_EQ(at(0.0), at(0.1)) << "inside the disc";
}

TEST(ToneMapping, MapsEveryColourIntoTheGamutWithoutClipping) {
  for (const auto& light : many_lights()) {
    const glm::dvec3 shown = tone_mapped(light, 1e-4);
    for (int c = 0; c < 3; ++c) {
      EXPECT_GE(shown[c], -1e-12);
      EXPECT_LE(shown[c], 1.0 + 1e-12);
    }
  }
}

TEST(ToneMapping, PreservesTheHueAsTheDirectionFromGrey) {
  for (const auto& light : many_lights()) {
    const glm::dvec3 before = light - luminance_of(light), shown = tone_mapped(light, 1e-4);
    const glm::dvec3 after = shown - luminance_of(shown);
    if (glm::length(after) < 1e-6 || glm::length(before) < 1e-3 * luminance_of(light)) continue;
    EXPECT_GT(glm::dot(glm::normalize(before), glm::normalize(after)), 1.0 - 1e-9);
  }
}

TEST(ToneMapping, LeavesColoursWellInsideTheGamutUnchanged) {
  const glm::dvec3 light(1800.0, 2000.0, 2400.0), shown = tone_mapped(light, 1e-4);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(shown[c] / luminance_of(shown), light[c] / luminance_of(light), 1e-12);
}

TEST(ToneMapping, KeepsDistinctColoursDistinct) {
  // Ever farther from grey at one luminance: clipping would make them all the same.
  double before = -1.0;
  for (double reach = 0.0; reach < 40.0; reach += 0.25) {
    const glm::dvec3 from_grey(1.0, 0.0, -0.2126 / 0.0722);
    const double out = glm::length(tone_mapped(3000.0 * (glm::dvec3(1.0) + reach * from_grey), 1e-4) -
                                   glm::dvec3(shown_luminance(0.3)));
    EXPECT_GT(out, before);
    before = out;
  }
}

TEST(SrgbEncoding, MatchesTheStandard) {
  const glm::dvec3 encoded = sky_text::srgb_encoded({0.001, 0.2140411, 1.0});
  EXPECT_NEAR(encoded.x, 0.01292, 1e-9);
  EXPECT_NEAR(encoded.y, 0.5, 1e-6);
  EXPECT_NEAR(encoded.z, 1.0, 1e-12);
}

PanoramaView view_with(PanoramaProjection projection, double focal_px) {
  return {projection, 400, 300, focal_px, camera_to_world(from_degrees(30.0), from_degrees(20.0), from_degrees(5.0))};
}

TEST(SkyProjections, RoundTripFromPixelToDirectionAndBack) {
  for (const auto projection :
       {PanoramaProjection::perspective, PanoramaProjection::fisheye, PanoramaProjection::equirectangular}) {
    const PanoramaView view = view_with(projection, 150.0);
    for (int y = 0; y < 300; y += 23)
      for (int x = 0; x < 400; x += 29) {
        const Direction direction = direction_of(view, {x, y});
        EXPECT_NEAR(glm::length(direction), 1.0, 1e-12);
        const auto back = pixel_of(view, direction);
        ASSERT_TRUE(back.has_value());
        EXPECT_NEAR(back->x, x, 1e-6);
        EXPECT_NEAR(back->y, y, 1e-6);
      }
  }
}

TEST(SkyProjections, MapAnglesAsTheirNamesSay) {
  const glm::dvec2 middle(199.5, 149.5);
  const auto turned = [&](PanoramaProjection projection, glm::dvec2 by) {
    const PanoramaView view = view_with(projection, 100.0);
    return angle_between(direction_of(view, middle), direction_of(view, middle + by)).value;
  };
  EXPECT_NEAR(turned(PanoramaProjection::perspective, {0.0, 100.0}), std::atan(1.0), 1e-12);
  EXPECT_NEAR(turned(PanoramaProjection::fisheye, {60.0, 80.0}), 1.0, 1e-12);
  EXPECT_NEAR(turned(PanoramaProjection::equirectangular, {0.0, 50.0}), 0.5, 1e-12);
  EXPECT_NEAR(turned(PanoramaProjection::equirectangular, {50.0, 0.0}), 0.5, 1e-12);
}

TEST(SkyProjections, AFisheyeShowsHalfASphere) {
  const PanoramaView view{PanoramaProjection::fisheye, 300, 300, 300.0 / kPi, glm::dmat3(1.0)};
  EXPECT_EQ(seen_share(view, {149.5, 1.0}), 1.0);
  EXPECT_EQ(seen_share(view, {20.0, 20.0}), 0.0);
}

// Sea-level metres of haze, summed along a straight line past a round Earth: the integral that air_along approximates.
double summed_haze_m(double from_m, double to_m, double length_m) {
  constexpr double kEarth_m = 6371000.0;
  const double a = kEarth_m + from_m, b = kEarth_m + to_m;
  constexpr int kSteps = 20000;
  double sum = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const double t = (i + 0.5) / kSteps;
    // Stewart's theorem: distance from the earth's centre at the fraction t of the path.
    const double r = std::sqrt((1.0 - t) * a * a + t * b * b - t * (1.0 - t) * length_m * length_m);
    sum += std::exp(-(r - kEarth_m) / 1200.0);
  }
  return length_m * sum / kSteps;
}

TEST(AirPath, EqualsTheIntegralOfTheHazeBetweenAnyTwoAltitudes) {
  struct Path {
    double from_m, to_m, length_m;
  };
  for (const Path& p : {Path{0, 0, 5e3},
                        {0, 0, 60e3},
                        {0, 2000, 2000},
                        {0, 3000, 40e3},
                        {3000, 0, 20e3},
                        {3000, 1500, 60e3},
                        {500, 510, 10e3},
                        {3000, 3000, 30e3},
                        {10e3, 0, 100e3}}) {
    const double along = sky_text::air_along(p.from_m, p.to_m, p.length_m).y;
    const double summed = summed_haze_m(p.from_m, p.to_m, p.length_m);
    EXPECT_NEAR(along / summed, 1.0, 0.02) << p.from_m << " m to " << p.to_m << " m, " << p.length_m << " m long";
    EXPECT_DOUBLE_EQ(along, sky_text::air_along(p.to_m, p.from_m, p.length_m).y);
  }
}

TEST(SkyText, HasTheNumbersOfTheHeaders) {
  EXPECT_EQ(sky_text::kEarthRadius_m, kEarthRadius_m);
  EXPECT_EQ(sky_text::kAngles, kDomeAngles);
  EXPECT_EQ(sky_text::kPowers, kDomePowers);
  EXPECT_EQ(sky_text::kSunDisc_sr, kSunDisc_sr);
  EXPECT_DOUBLE_EQ(from_degrees(sky_text::kSunRadius_deg).value, kSunRadius.value);
}

TEST(AirPath, GrowsWithItsLengthAndNeverTurnsNegative) {
  // As in U Eq 3.3.
  for (const double rise_m : {0.0, 1.0, 49.0, 51.0, 900.0}) {
    double before = 0.0;
    for (double length_m = std::max(rise_m, 1.0); length_m < 200e3; length_m *= 1.7) {
      const glm::dvec3 along = sky_text::air_along(100.0, 100.0 + rise_m, length_m);
      EXPECT_GT(along.x, before);
      EXPECT_GT(along.y, 0.0);
      before = along.x;
    }
  }
}

// An arbitrary sky: colour and intensity vary with zenith angle and angle to the sun.
DomeFunction some_sky(double horizon_sine, double strength) {
  DomeFunction sky;
  sky.horizon_sine = static_cast<float>(horizon_sine);
  sky.steepness = 6.0f;
  sky.lobes = {0.8f, 0.5f, -0.4f};
  const auto put = [&](int angle, int power, glm::vec3 colour) {
    sky.coefficients[static_cast<std::size_t>(angle * kDomePowers + power)] = static_cast<float>(strength) * colour;
  };
  put(0, 0, {900.0f, 1500.0f, 3500.0f});
  put(0, 1, {4000.0f, 5000.0f, 6500.0f});
  put(2, 1, {500.0f, 700.0f, 1100.0f});
  put(3, 0, {30000.0f, 29000.0f, 26000.0f});
  return sky;
}

DomeScene some_scene() {
  DomeScene scene;
  scene.sun = direction_from(from_degrees(50.0), from_degrees(120.0));
  scene.altitude_m = 500.0;
  scene.lower_m = 0.0;
  scene.higher_m = 4000.0;
  scene.lower = some_sky(0.0, 1.0);
  scene.higher = some_sky(0.0, 0.6);
  for (std::size_t n = 0; n < kAirNodes; ++n) {
    scene.air.weight[n] = glm::vec3(0.5f);
    scene.air.molecules_per_m[n] = glm::vec3(5e-6f, 12e-6f, 28e-6f);
    scene.air.aerosol_per_m[n] = glm::vec3(8e-5f);
  }
  return scene;
}

TEST(AnObjectInTheAir, KeepsItsLightAtZeroDistance) {
  const DomePainter painter(some_scene());
  const glm::dvec3 light(100.0, 200.0, 300.0);
  const glm::dvec3 seen = painter.through_air(light, {0.0, 1.0, 500.0}, 500.0);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(seen[c], light[c], 2.0);  // cd/m2, of skies of 10,000
}

TEST(AnObjectInTheAir, FadesIntoTheHorizonsLightFarAway) {
  DomeScene scene = some_scene();
  scene.higher = scene.lower;  // the sky is known at the path's own altitude
  scene.lower_m = 499.0;
  scene.higher_m = 501.0;
  const DomePainter painter(scene);
  const Direction north(0.0, 1.0, 0.0);
  const glm::dvec3 horizon = sky_text::dome_sky_light(text_of(scene.lower), 0.0, glm::dot(north, scene.sun));
  const glm::dvec3 seen = painter.through_air({0.0, 0.0, 0.0}, {0.0, 400e3, 500.0}, 500.0);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(seen[c] / horizon[c], 1.0, 0.03);
}

TEST(AnObjectInTheAir, LooksTheSameFromBothEndsOfALevelPath) {
  // With sky or ground behind it: the two cases agree.
  const DomePainter painter(some_scene());
  const glm::dvec3 light(2000.0, 2000.0, 2000.0);
  const glm::dvec3 above = painter.through_air(light, {0.0, 20e3, 500.5}, 500.5);
  const glm::dvec3 below = painter.through_air(light, {0.0, 20e3, 499.5}, 499.5);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(above[c] / below[c], 1.0, 2e-3);
}

TEST(TheSunsDisc, HasTheGivenMeanLuminance) {
  const glm::dvec3 mean(1.2e9, 1.1e9, 0.9e9);
  glm::dvec3 sum(0.0);
  constexpr int kRings = 4000;
  for (int i = 0; i < kRings; ++i) {
    const double off = (i + 0.5) / kRings;
    sum += sky_text::sun_disc_light(mean, off) * 2.0 * off / static_cast<double>(kRings);
  }
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(sum[c] / mean[c], 1.0, 1e-3);
  EXPECT_GT(sky_text::sun_disc_light(mean, 0.0).x, sky_text::sun_disc_light(mean, 0.9).x);
}

TEST(TheSunsDisc, IsAsLargeAsTheSun) {
  DomeScene scene = some_scene();
  scene.sky = some_sky(0.0, 1.0);
  scene.sun_luminance = glm::dvec3(1e9);
  const DomePainter painter(scene);
  const auto lit = [&](double off_rad) {
    const Direction view = direction_from(from_degrees(50.0) - Radians{off_rad}, from_degrees(120.0));
    return painter.sky_and_sun(view, 1e-5).y > 1e7;
  };
  EXPECT_TRUE(lit(0.0046));
  EXPECT_FALSE(lit(0.0047));
}

TEST(HoffmanAndPreetham, ConvergeToTheRatioOfTheirCoefficientsOnALongPath) {
  // Eq 2.26 with F = 0, at a right angle to the sun: 3 / (16 pi) E for air without haze.
  sky_text::OlderAir air{};
  air.rayleigh_per_m = glm::dvec3(1e-2);
  air.sunlight = glm::dvec3(1000.0);  // E / pi
  const glm::dvec3 light = sky_text::hoffman_preetham_sky(air, 0.5, 0.0);
  EXPECT_NEAR(light.x, 3.0 / 16.0 * 1000.0, 1e-6);
  EXPECT_NEAR(sky_text::nielsen_sky(air, 0.5, 1.0).x / sky_text::nielsen_sky(air, 0.5, 0.0).x, 1.5, 1e-9);
  EXPECT_NEAR(sky_text::hoffman_preetham_sky(air, 0.5, 1.0).x / light.x, 2.0, 1e-9);
}

}  // namespace
}  // namespace kasumi
