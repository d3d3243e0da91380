#include <cmath>
#include <map>
#include <string>

#include <gtest/gtest.h>

#include "estimator/sky_camera/sun_in_image.hpp"
#include "tests/estimator/sky_camera/labelled_skies.hpp"
#include "tests/estimator/turbidity/synthetic_sky.hpp"
#include "tests/must.hpp"

namespace kasumi {
namespace {

struct Seen {
  Camera camera;
  Image<Rgb8> image;
  Direction sun;
  std::optional<SunBlob> find() const {
    return find_sun(*sky_picture(view_of(image), camera, 800), camera, {.by_shape = true});
  }
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
  const auto blob = must(seen.find());
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

// A blue sky of one brightness, in which only what is painted is bright.
Seen blue_sky(std::uint8_t dimmest = 70) {
  Seen seen{test::upward_camera(600), {}, direction_from(from_degrees(40), from_degrees(120))};
  seen.image = Image<Rgb8>(600, 600);
  for (int y = 0; y < 600; ++y)
    for (int x = 0; x < 600; ++x)
      if (seen.camera.direction_at({x, y}))
        seen.image.at(x, y) = {dimmest, static_cast<std::uint8_t>(dimmest + 40),
                               static_cast<std::uint8_t>(dimmest + 90)};
  return seen;
}

// Glare around the sun's picture, or around a bright cloud's: level 255 inside the radius, then less.
void paint_glare(Image<Rgb8>& image, glm::dvec2 centre, double radius) {
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) {
      const double further = glm::length(glm::dvec2{x, y} - centre) - radius;
      const auto level = static_cast<std::uint8_t>(255.0 * std::exp(-std::max(0.0, further) / 60.0));
      image.at(x, y) = glm::max(image.at(x, y), Rgb8(level));
    }
}

constexpr Rgb8 kWhite{255, 255, 255};

TEST(SunInImage, IsFoundInABloomBesideACloudWithStreaksDropsAndGhosts) {
  for (const double radius : {6.0, 15.0, 30.0}) {  // 2 to 10 deg
    Seen seen = blue_sky();
    const glm::dvec2 sun = *seen.camera.pixel_of(seen.sun);
    paint_glare(seen.image, sun, radius);
    paint(seen.image, sun + glm::dvec2{radius + 5.0, 4.0}, 0.5 * radius, kWhite);       // a cloud that touches it
    for (int y = 40; y < 560; ++y) seen.image.at(static_cast<int>(sun.x), y) = kWhite;  // a smear
    paint(seen.image, glm::dvec2{598.0} - sun, 0.4 * radius, {230, 200, 240});          // a ghost opposite to it
    for (const glm::dvec2 drop : {glm::dvec2{200, 210}, glm::dvec2{260, 330}, glm::dvec2{300, 180}})
      paint(seen.image, drop, 1.5, kWhite);
    const auto blob = seen.find();
    ASSERT_TRUE(blob) << radius;
    EXPECT_LT(to_degrees(angle_between(blob->direction, seen.sun)), 1.5) << radius;
    EXPECT_LT(angle_between(blob->direction, seen.sun).value, 2.5 * blob->sigma.value) << radius;
  }
}

TEST(SunInImage, IsFoundWhereTheSensorShowsItBlack) {
  Seen seen = blue_sky();
  const glm::dvec2 sun = *seen.camera.pixel_of(seen.sun);
  paint_glare(seen.image, sun, 20.0);
  paint(seen.image, sun + glm::dvec2{3.0, 0.0}, 4.0, {20, 20, 20});
  const auto blob = must(seen.find());
  EXPECT_LT(to_degrees(angle_between(blob->direction, seen.sun)), 0.5);
}

TEST(SunInImage, IsNoneOfManyWhiteClouds) {
  Seen seen = blue_sky(110);
  for (int k = 0; k < 12; ++k) {
    const double turn = 2.4 * k, distance = 60.0 + 15.0 * k;
    const glm::dvec2 at = 299.5 + distance * glm::dvec2{std::cos(turn), std::sin(turn)};
    paint(seen.image, at, 14.0, kWhite);
    paint(seen.image, at + glm::dvec2{14.0, 6.0}, 10.0, kWhite);
  }
  EXPECT_FALSE(seen.find());
}

TEST(SunInImage, IsNotWhatIsWhiteOutsideTheCircle) {
  Seen seen = blue_sky();
  for (int y = 0; y < 600; ++y)
    for (int x = 0; x < 600; ++x)
      if (!seen.camera.direction_at({x, y})) seen.image.at(x, y) = kWhite;
  EXPECT_FALSE(seen.find());
}

TEST(SunInImage, IsTheOneOfTwoThatTimeAndPlaceExpect) {
  Seen seen = blue_sky();
  const SunDirection other = direction_from(from_degrees(65), from_degrees(280));
  for (const SunDirection& place : {seen.sun, other}) paint_glare(seen.image, *seen.camera.pixel_of(place), 9.0);
  const auto picture = *sky_picture(view_of(seen.image), seen.camera, 800);
  for (const SunDirection& place : {seen.sun, other})
    for (const bool azimuth_known : {true, false}) {
      // 3 deg off, and turned where the azimuth is not known.
      const Radians turn = azimuth_known ? Radians{0.0} : from_degrees(77);
      const SunDirection expected = direction_from(zenith_angle(place) + from_degrees(3), azimuth_angle(place) + turn);
      const auto blob = find_sun(picture, seen.camera,
                                 {.by_shape = true, .expected = ExpectedSun{expected, from_degrees(2), azimuth_known}});
      ASSERT_TRUE(blob) << azimuth_known;
      EXPECT_LT(to_degrees(angle_between(blob->direction, place)), 0.5) << azimuth_known;
    }
}

TEST(SunInImage, IsLessSureWhereItIsNotExpected) {
  Seen seen = blue_sky(130);
  paint_glare(seen.image, *seen.camera.pixel_of(seen.sun), 9.0);
  const auto picture = *sky_picture(view_of(seen.image), seen.camera, 800);
  const auto sure = [&](const std::optional<ExpectedSun>& expected) {
    const auto blob = find_sun(
        picture, seen.camera, {.least_by_aureole = 0.0, .least_by_shape = 0.0, .by_shape = true, .expected = expected});
    return blob ? blob->confidence : 0.0;
  };
  const double alone = sure(std::nullopt);
  EXPECT_GT(sure(ExpectedSun{seen.sun}), alone);
  EXPECT_LT(sure(ExpectedSun{direction_from(from_degrees(20), from_degrees(300))}), alone);
}

TEST(SunInImage, IsTheSameInACroppedPicture) {
  Seen seen = blue_sky();
  const glm::dvec2 sun = *seen.camera.pixel_of(seen.sun);
  paint_glare(seen.image, sun, 22.0);
  paint(seen.image, sun + glm::dvec2{26.0, 10.0}, 12.0, kWhite);
  const auto whole = must(find_sun(*sky_picture(view_of(seen.image), seen.camera), seen.camera, {.by_shape = true}));
  for (const int left : {0, 1, 7, 30})
    for (const int top : {0, 3, 45}) {
      Image<Rgb8> part(590 - left, 585 - top);
      for (int y = 0; y < part.height(); ++y)
        for (int x = 0; x < part.width(); ++x) part.at(x, y) = seen.image.at(x + left, y + top);
      Camera camera = seen.camera;
      camera.width = part.width();
      camera.height = part.height();
      const double edge = 0.5 * kPi;
      const double focal = glm::distance(sun, glm::dvec2{299.5}) / from_degrees(40).value;
      camera.lens = equidistant_lens(glm::dvec2{299.5} - glm::dvec2{left, top}, focal, {edge});
      const auto blob = find_sun(*sky_picture(view_of(part), camera), camera, {.by_shape = true});
      ASSERT_TRUE(blob) << left << " " << top;
      EXPECT_LT(to_degrees(angle_between(blob->direction, whole->direction)), 0.4) << left << " " << top;
      EXPECT_NEAR(blob->confidence, whole->confidence, 0.1) << left << " " << top;
    }
}

TEST(SunInImage, IsFoundInMostPicturesOfStrangersAndInNoneOfThoseWithoutIt) {
  const auto skies = test::labelled_skies();
  if (skies.empty()) GTEST_SKIP() << "no shared data: sky/real";
  std::map<std::string, std::pair<int, int>> found, told;  // of each camera: so many, of so many
  for (const auto& sky : skies) {
    if (!sky.sun_scored) continue;
    const auto blob = find_sun(*sky_picture(view_of(sky.pixels), sky.camera), sky.camera, {.by_shape = true});
    if (sky.sun_px) {
      const double off = blob ? glm::distance(blob->pixel, *sky.sun_px) / sky.tolerance_px : 0.0;
      auto& [good, all] = found[sky.name];
      good += blob && off <= 1.0 ? 1 : 0;
      ++all;
      EXPECT_LE(off, 2.0) << sky.file;
    } else {
      auto& [wrong, all] = told[sky.name];
      wrong += blob ? 1 : 0;
      ++all;
      EXPECT_FALSE(blob) << sky.file;
    }
  }
  double share = 0.0;
  for (const auto& [name, count] : found) {
    std::printf("%s: %d of %d suns\n", name.c_str(), count.first, count.second);
    share += static_cast<double>(count.first) / count.second / static_cast<double>(found.size());
  }
  for (const auto& [name, count] : told)
    std::printf("%s: %d told in %d pictures without\n", name.c_str(), count.first, count.second);
  EXPECT_GE(share, 0.9);
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
