#include <gtest/gtest.h>

#include "estimator/sky_camera/sun_in_image.hpp"
#include "tests/estimator/turbidity/synthetic_sky.hpp"

namespace kasumi {
namespace {

struct Seen {
  Camera camera;
  Image<Rgb8> image;
  Direction sun;
  std::optional<SunBlob> find() const { return find_sun(*sky_picture(view_of(image), camera, 800), camera); }
};

Seen see(const test::SyntheticSky& description, int side = 600) {
  Seen seen{test::upward_camera(side), {}, {}};
  const test::RenderedSky rendered = test::render(description, seen.camera);
  seen.image = rendered.to_8_bit();
  seen.sun = rendered.sun;
  return seen;
}

void paint(Image<Rgb8>& image, glm::dvec2 centre, double radius, Rgb8 colour) {
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x)
      if (glm::length(glm::dvec2{x, y} - centre) <= radius) image.at(x, y) = colour;
}

TEST(SunInImage, IsFoundToAFractionOfAPixel) {
  for (const double zenith : {20.0, 45.0, 70.0})
    for (const double azimuth : {10.0, 137.0, 251.0}) {
      Seen seen = see({.turbidity = 4.0, .sun_zenith_deg = zenith, .sun_azimuth_deg = azimuth, .exposure = 0.6});
      paint(seen.image, *seen.camera.pixel_of(seen.sun), 4.3, {255, 255, 255});  // bloomed by the lens
      const auto blob = seen.find();
      ASSERT_TRUE(blob) << zenith << " " << azimuth;
      EXPECT_LT(to_degrees(angle_between(blob->direction, seen.sun)), 0.15)
          << zenith << " " << azimuth;  // half a pixel
      EXPECT_GT(blob->confidence, 0.5);
    }
}

TEST(SunInImage, IsNearTheSunOrNotFoundInASaturatedAureole) {
  for (const double exposure : {0.3, 0.6, 0.9, 1.25}) {
    const Seen seen = see({.turbidity = 5.0, .exposure = exposure});
    const auto blob = seen.find();
    if (blob) {
      EXPECT_LT(to_degrees(angle_between(blob->direction, seen.sun)), 1.5) << exposure;
    }
  }
}

TEST(SunInImage, IsNotMistakenForAReflection) {
  Seen seen = see({.turbidity = 4.0, .exposure = 0.6});
  paint(seen.image, *seen.camera.pixel_of(seen.sun), 4.3, {255, 255, 255});
  const Direction opposite = direction_from(from_degrees(50), from_degrees(20));  // a window, away from the sun
  paint(seen.image, *seen.camera.pixel_of(opposite), 5.0, {255, 255, 255});
  for (int x = 200; x < 330; ++x)  // and glare across the dome
    for (int y = 420; y < 426; ++y) seen.image.at(x, y) = {255, 255, 255};
  const auto blob = seen.find();
  ASSERT_TRUE(blob);
  EXPECT_LT(to_degrees(angle_between(blob->direction, seen.sun)), 0.3);
}

TEST(SunInImage, IsNotSeenInACloudyOrCoveredOrOverExposedSky) {
  EXPECT_FALSE(see({.sun_disc = false, .weather = test::Weather::overcast, .exposure = 0.3}).find());
  EXPECT_FALSE(see({.weather = test::Weather::covered_dark}).find());
  EXPECT_FALSE(see({.weather = test::Weather::covered_bright}).find());
  EXPECT_FALSE(see({.turbidity = 6.0, .exposure = 30.0}).find());
  Seen hot = see({.weather = test::Weather::covered_dark});
  hot.image.at(200, 300) = {255, 255, 255};  // a hot pixel has no aureole
  EXPECT_FALSE(hot.find());
}

TEST(CrossCheck, UsesTheEphemerisWithATrustedClockAndTheImageWithout) {
  const SunDirection ephemeris = direction_from(from_degrees(40), from_degrees(100));
  const SunBlob blob{direction_from(from_degrees(41), from_degrees(100)), {}, {}, 0.9, {}};
  const SunCheck trusted = cross_check(ephemeris, blob, true);
  EXPECT_EQ(trusted.source, SunSource::ephemeris);
  EXPECT_EQ(trusted.direction, ephemeris);
  EXPECT_TRUE(trusted.agrees);
  EXPECT_NEAR(to_degrees(*trusted.disagreement), 1.0, 1e-9);
  const SunCheck untrusted = cross_check(ephemeris, blob, false);
  EXPECT_EQ(untrusted.source, SunSource::image);
  EXPECT_EQ(untrusted.direction, blob.direction);
}

TEST(CrossCheck, NamesADisagreementInDegrees) {
  const SunDirection ephemeris = direction_from(from_degrees(40), from_degrees(100));
  const SunBlob blob{direction_from(from_degrees(60), from_degrees(100)), {}, {}, 0.9, {}};
  const SunCheck check = cross_check(ephemeris, blob, true);
  EXPECT_FALSE(check.agrees);
  EXPECT_NE(check.message.find("20.0 deg"), std::string::npos) << check.message;
  EXPECT_NE(check.message.find("orientation"), std::string::npos) << check.message;
}

TEST(CrossCheck, KnowsNoSunWithoutClockAndBlob) {
  EXPECT_EQ(cross_check(direction_from({0.5}, {0.1}), std::nullopt, false).source, SunSource::none);
  EXPECT_EQ(cross_check(std::nullopt, std::nullopt, true).source, SunSource::none);
  EXPECT_EQ(cross_check(direction_from({0.5}, {0.1}), std::nullopt, true).source, SunSource::ephemeris);
}

TEST(CrossCheck, SaysThatNoSunIsSeenOnlyWhereSomebodyLooked) {
  const SunDirection ephemeris = direction_from(from_degrees(40), from_degrees(100));
  EXPECT_EQ(cross_check(ephemeris, std::nullopt, true, true).message, "no sun is seen in the image");
  EXPECT_EQ(cross_check(ephemeris, std::nullopt, true, false).message.find("no sun"), std::string::npos);
}

TEST(CrossCheck, SaysHowSureTheSunInTheImageIs) {
  const SunBlob blob{direction_from(from_degrees(41), from_degrees(100)), {}, {}, 0.97, from_degrees(0.4)};
  EXPECT_EQ(how_sure(blob), "+- 0.4 deg, 97 % sure");
  for (const bool trusted : {false, true})
    EXPECT_NE(cross_check(direction_from(from_degrees(40), from_degrees(100)), blob, trusted).message.find("97 % sure"),
              std::string::npos);
  EXPECT_NE(cross_check(std::nullopt, blob, false).message.find("97 % sure"), std::string::npos);
}

}  // namespace
}  // namespace kasumi
