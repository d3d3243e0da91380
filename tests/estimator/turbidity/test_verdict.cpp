#include <gtest/gtest.h>

#include "estimator/turbidity/sky_verdict.hpp"
#include "estimator/turbidity/turbidity.hpp"
#include "tests/estimator/turbidity/synthetic_sky.hpp"

namespace kasumi {
namespace {

using test::Weather;

TurbidityEstimate judge(const test::SyntheticSky& description, const EstimateParameters& options = {},
                        const std::function<void(Image<Rgb8>&)>& spoil = {}) {
  const Camera camera = test::upward_camera(400);
  const test::RenderedSky rendered = test::render(description, camera);
  Image<Rgb8> image = rendered.to_8_bit();
  if (spoil) spoil(image);
  return estimate_turbidity(*sky_picture(view_of(image), camera), camera, rendered.sun, options);
}

void expect_refused(const TurbidityEstimate& estimate, SkyCondition sky, const std::string& word) {
  EXPECT_FALSE(estimate.usable) << "T " << estimate.turbidity.value << " +- " << estimate.sigma << ", residual "
                                << estimate.log_residual;
  EXPECT_EQ(name_of(estimate.sky), name_of(sky)) << estimate.reason;
  EXPECT_NE(estimate.reason.find(word), std::string::npos) << estimate.reason;
  std::printf("%s\n", estimate.reason.c_str());
}

EstimateParameters every_model() {
  EstimateParameters options;
  options.sky.every_model = true;
  return options;
}

// An uncertain depth is an answer as long as it excludes something.
TEST(Verdict, OnlyADepthThatExcludesNothingIsRefusedForItsSigma) {
  EXPECT_FALSE(refuse_by_sigma(0.03, 0.05)) << "surely clear air";
  EXPECT_FALSE(refuse_by_sigma(0.24, 0.26)) << "no thick haze";
  EXPECT_FALSE(refuse_by_sigma(0.9, 0.5)) << "surely no clear air";
  const auto refused = refuse_by_sigma(0.35, 0.4);
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->sky, SkyCondition::unknown);
  EXPECT_NE(refused->reason.find("0.35 is uncertain by 0.40"), std::string::npos) << refused->reason;
}

TEST(Verdict, UsesAClearSky) {
  const TurbidityEstimate estimate = judge({.turbidity = 3.0});
  EXPECT_TRUE(estimate.usable) << estimate.reason;
  EXPECT_EQ(estimate.sky, SkyCondition::clear);
  EXPECT_TRUE(estimate.reason.empty());
  EXPECT_GT(estimate.clear_fraction, 0.97);
  EXPECT_NEAR(estimate.turbidity.value, 3.0, 5.0 * estimate.sigma);
}

TEST(Verdict, UsesTheGapsOfAPartlyCloudySky) {
  const TurbidityEstimate estimate = judge({.turbidity = 3.0, .cloud_cover = 0.5});
  EXPECT_TRUE(estimate.usable) << estimate.reason;
  EXPECT_EQ(estimate.sky, SkyCondition::partly_cloudy);
  EXPECT_NEAR(estimate.clear_fraction, 0.5, 0.2);
}

TEST(Verdict, RefusesOvercastSkiesOfEverySunHeightAndTexture) {
  for (const double sun : {15.0, 40.0, 58.4, 75.0})
    for (const std::uint64_t seed : {1u, 2u, 3u})
      expect_refused(judge({.sun_zenith_deg = sun,
                            .cloud_seed = seed,
                            .sun_disc = false,
                            .weather = Weather::overcast,
                            .exposure = 0.5}),
                     SkyCondition::overcast, "overcast");
}

TEST(Verdict, RefusesASkyFullOfBrokenClouds) {
  for (const std::uint64_t seed : {1u, 2u, 3u})
    expect_refused(judge({.turbidity = 3.0, .cloud_cover = 0.97, .cloud_seed = seed, .exposure = 0.5}),
                   SkyCondition::overcast, "%");
}

TEST(Verdict, RefusesFog) {
  for (const double sun : {20.0, 58.4})
    expect_refused(judge({.sun_zenith_deg = sun, .sun_disc = false, .weather = Weather::fog, .exposure = 0.5}),
                   SkyCondition::overcast, "fog");
}

TEST(Verdict, RefusesACoveredLensDarkOrBright) {
  expect_refused(judge({.weather = Weather::covered_dark}), SkyCondition::covered_lens, "covered");
  expect_refused(judge({.weather = Weather::covered_dark, .noise = 0.02}), SkyCondition::covered_lens, "covered");
  expect_refused(judge({.weather = Weather::covered_bright}), SkyCondition::covered_lens, "covered");
  expect_refused(judge({.weather = Weather::covered_bright, .noise = 0.03}), SkyCondition::covered_lens, "covered");
}

TEST(Verdict, RefusesNightAndALowSunBeforeLookingAtThePicture) {
  const Camera camera = test::upward_camera(100);
  const SkyPicture black = *sky_picture(Image<glm::vec3>(100, 100), 1.0 / 255, camera);
  const auto at = [&](double elevation) {
    return estimate_turbidity(black, camera, direction_from(from_degrees(90 - elevation), {1.0}));
  };
  expect_refused(at(-20.0), SkyCondition::night, "20.0 deg below");
  expect_refused(at(-3.0), SkyCondition::sun_too_low, "-3.0 deg");
  expect_refused(at(2.9), SkyCondition::sun_too_low, "2.9 deg < 3.0 deg");
}

TEST(Verdict, DistinguishesBadExposureFromBadWeather) {
  expect_refused(judge({.turbidity = 3.0, .exposure = 40.0}), SkyCondition::unknown, "over-exposed");
  expect_refused(judge({.turbidity = 3.0, .exposure = 0.003}), SkyCondition::unknown, "under-exposed");
}

TEST(Verdict, RefusesASunThatIsNotADirection) {
  const Camera camera = test::upward_camera(100);
  const SkyPicture picture = *sky_picture(Image<glm::vec3>(100, 100), 1.0 / 255, camera);
  expect_refused(estimate_turbidity(picture, camera, SunDirection{0.0, 0.0, 0.0}), SkyCondition::unknown, "sun");
}

TEST(Verdict, RefusesAViewWithoutSky) {
  Camera camera = test::upward_camera(100);
  camera.mask = Image<std::uint8_t>(100, 100, 0);
  const SkyPicture picture = *sky_picture(Image<glm::vec3>(100, 100, glm::vec3{0.5f}), 1.0 / 255, camera);
  expect_refused(estimate_turbidity(picture, camera, direction_from({0.8}, {0.1})), SkyCondition::unknown, "open sky");
}

// Half the dome behind a wood that is not masked: leaves are dark, green and textured.
TEST(Verdict, SeesTheSkyBesideAWood) {
  const TurbidityEstimate estimate = judge({.turbidity = 3.0}, {}, [](Image<Rgb8>& image) {
    for (int y = 0; y < 400; ++y)
      for (int x = 0; x < 190; ++x) {
        const double leaf = test::hashed_uniform(5, static_cast<std::uint64_t>(y / 2 * 400 + x / 2));
        image.at(x, y) = {static_cast<std::uint8_t>(20 + 60 * leaf), static_cast<std::uint8_t>(30 + 90 * leaf),
                          static_cast<std::uint8_t>(10 + 30 * leaf)};
      }
  });
  EXPECT_TRUE(estimate.usable) << estimate.reason;
  EXPECT_NEAR(estimate.turbidity.value, 3.0, 0.05);
  EXPECT_NEAR(estimate.clear_fraction, 0.5, 0.15);
}

// Forty drops on the dome, each a small bright lens.
TEST(Verdict, SeesTheSkyBetweenRainDrops) {
  const TurbidityEstimate estimate = judge({.turbidity = 4.0}, {}, [](Image<Rgb8>& image) {
    for (std::uint64_t drop = 0; drop < 40; ++drop) {
      const glm::dvec2 centre{400 * test::hashed_uniform(1, drop), 400 * test::hashed_uniform(2, drop)};
      const double radius = 4 + 8 * test::hashed_uniform(3, drop);
      for (int y = 0; y < 400; ++y)
        for (int x = 0; x < 400; ++x) {
          const double r = glm::length(glm::dvec2{x, y} - centre) / radius;
          if (r < 1.0)
            for (int c = 0; c < 3; ++c)
              image.at(x, y)[c] = static_cast<std::uint8_t>(std::min(250.0, image.at(x, y)[c] * (0.75 + 0.6 * r)));
        }
    }
  });
  EXPECT_TRUE(estimate.usable) << estimate.reason;
  EXPECT_NEAR(estimate.turbidity.value, 4.0, 0.1);
}

// Moonlight is sunlight seen with a long exposure: only the ephemeris can tell the difference.
TEST(Verdict, IsNotFooledByMoonlight) {
  const Camera camera = test::upward_camera(400);
  const Image<Rgb8> image = test::render({.turbidity = 3.0}, camera).to_8_bit();
  expect_refused(estimate_turbidity(*sky_picture(view_of(image), camera), camera,
                                    direction_from(from_degrees(130), from_degrees(20))),
                 SkyCondition::night, "night");
}

// Clock or orientation wrong by a quarter turn: no clear sky fits well.
TEST(Verdict, DoesNotTrustAClearSkyWhoseSunIsElsewhere) {
  const Camera camera = test::upward_camera(400);
  const test::RenderedSky rendered = test::render({.turbidity = 2.5}, camera);
  const Image<Rgb8> image = rendered.to_8_bit();
  for (const double turn : {90.0, 180.0}) {
    const Direction wrong = direction_from(from_degrees(58.4), from_degrees(-179.4 + turn));
    const TurbidityEstimate estimate = estimate_turbidity(*sky_picture(view_of(image), camera), camera, wrong);
    EXPECT_FALSE(estimate.usable) << "T " << estimate.turbidity.value << ", residual " << estimate.log_residual;
    std::printf("%s\n", estimate.reason.c_str());
  }
}

// By all models of the sky.
TEST(VerdictOfEveryModel, UsesAClearSky) {
  for (const double turbidity : {2.2, 3.0, 6.0, 9.0}) {
    const TurbidityEstimate estimate = judge({.turbidity = turbidity}, every_model());
    EXPECT_TRUE(estimate.usable) << turbidity << ": " << estimate.reason;
    EXPECT_EQ(estimate.sky, SkyCondition::clear) << turbidity;
  }
}

TEST(VerdictOfEveryModel, UsesTheGapsOfAPartlyCloudySky) {
  const TurbidityEstimate estimate = judge({.turbidity = 3.0, .cloud_cover = 0.5}, every_model());
  EXPECT_TRUE(estimate.usable) << estimate.reason;
  EXPECT_EQ(estimate.sky, SkyCondition::partly_cloudy);
  EXPECT_NEAR(estimate.turbidity.value, 3.0, std::max(0.1, 3.0 * estimate.sigma));
}

TEST(VerdictOfEveryModel, RefusesOvercastSkiesAndFog) {
  for (const double sun : {15.0, 58.4, 75.0}) {
    expect_refused(
        judge({.sun_zenith_deg = sun, .sun_disc = false, .weather = Weather::overcast, .exposure = 0.5}, every_model()),
        SkyCondition::overcast, "overcast");
    expect_refused(
        judge({.sun_zenith_deg = sun, .sun_disc = false, .weather = Weather::fog, .exposure = 0.5}, every_model()),
        SkyCondition::overcast, "overcast");
  }
}

TEST(VerdictOfEveryModel, RefusesASkyFullOfBrokenClouds) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const TurbidityEstimate estimate =
        judge({.turbidity = 3.0, .cloud_cover = 0.97, .cloud_seed = seed, .exposure = 0.5}, every_model());
    EXPECT_FALSE(estimate.usable);
    EXPECT_TRUE(estimate.sky == SkyCondition::overcast || estimate.sky == SkyCondition::partly_cloudy)
        << estimate.reason;
    std::printf("%s\n", estimate.reason.c_str());
  }
}

TEST(VerdictOfEveryModel, NamesTheToneCurveOfACloudlessSky) {
  const Camera linear = test::upward_camera(400, 180.0, Response::linear()), believed = test::upward_camera(400);
  const test::RenderedSky rendered = test::render({.turbidity = 3.0, .exposure = 0.8}, linear);
  const Image<Rgb8> image = rendered.to_8_bit();
  expect_refused(estimate_turbidity(*sky_picture(view_of(image), believed), believed, rendered.sun, every_model()),
                 SkyCondition::unknown, "tone curve");
}

TEST(VerdictOfEveryModel, NamesGlareOfACloudlessSky) {
  expect_refused(judge({.turbidity = 2.5, .exposure = 0.5, .flare = 0.6}, every_model()), SkyCondition::unknown,
                 "glare");
}

}  // namespace
}  // namespace kasumi
