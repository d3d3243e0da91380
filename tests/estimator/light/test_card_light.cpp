// What cards of known reflectance make of the model's light.
#include <cmath>

#include <gtest/gtest.h>
#include <glm/glm.hpp>

#include "estimator/light/card_light.hpp"
#include "estimator/photograph/other_air.hpp"

namespace kasumi {
namespace {

constexpr int kWidth = 64, kHeight = 48;

// Sun in the south-west, the camera looks north: one card faces the sun, one the north, in the shade.
struct CardsInView : testing::Test {
  Camera camera = plain_camera(kWidth, kHeight, from_degrees(50.0), Radians{0.0});
  SunDirection sun = direction_from(from_degrees(50.0), from_degrees(220.0));
  AirState air{Aerosol{0.1, 1.3, AerosolKind::continental}};
  Daylight daylight{camera, air, sun, {SkyCondition::clear, 0.2, 100.0, DaylightModel::dome}};
  LightCard lit{"lit", 10, 30, 8, 6, glm::dvec3{0.4}, direction_from(from_degrees(90.0), from_degrees(200.0))};
  LightCard shaded{"shaded", 40, 30, 8, 6, {0.5, 0.4, 0.3}, direction_from(from_degrees(90.0), from_degrees(20.0))};

  glm::dvec3 model_light(const LightCard& card, const glm::dvec3& sun_factor, const glm::dvec3& around_factor) const {
    const auto& light = daylight.on_object();
    return card.reflectance / kPi *
           (sun_factor * std::max(0.0, glm::dot(card.normal, sun)) * light.sun_irradiance +
            around_factor * irradiance(light.around, card.normal));
  }
  HorizonLight horizon(double exposure, const glm::dvec3& gains) const {
    const auto towards = direction_from(from_degrees(89.0), Radians{0.0});
    HorizonLight seen;
    seen.source = HorizonLight::Source::scene_camera;
    seen.columns = {{Radians{0.0}, from_degrees(89.0), exposure * gains * daylight.airlight(towards), 1.0}};
    return seen;
  }
  // As the camera sees them, whatever its exposure and white balance.
  LightFactors found(const glm::dvec3& sun_factor, const glm::dvec3& around_factor, const std::vector<LightCard>& cards,
                     double exposure = 0.02, const glm::dvec3& gains = {0.7, 1.0, 1.2}) const {
    const auto behind = horizon(exposure, gains);
    Image<Rgb8> picture(kWidth, kHeight);
    std::vector<CardReading> readings;
    for (const auto& card : cards) {
      const auto code = camera.response.to_encoded(exposure * gains * model_light(card, sun_factor, around_factor));
      for (int y = card.y; y < card.y + card.height; ++y)
        for (int x = card.x; x < card.x + card.width; ++x) picture.at(x, y) = Rgb8(glm::round(255.0 * code));
      if (const auto over = card_over_horizon(card, camera, view_of(picture), behind, 1.0))
        readings.push_back(card_reading(card, *over, towards_card(card, camera, behind), daylight));
    }
    EXPECT_EQ(readings.size(), cards.size());
    return factors_by_cards(readings);
  }
};

TEST_F(CardsInView, LeaveTheModelAloneWhereItIsRight) {
  const auto factors = found(glm::dvec3{1.0}, glm::dvec3{1.0}, {lit, shaded});
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(factors.sun[c], 1.0, 0.02);
    EXPECT_NEAR(factors.around[c], 1.0, 0.02);
    EXPECT_LT(factors.sun_sigma[c], 0.14);
  }
}

TEST_F(CardsInView, TellSunAndSkyApartByChannel) {
  const glm::dvec3 sun_factor{0.85, 0.9, 0.95}, around_factor{1.1, 1.2, 1.25};
  const auto factors = found(sun_factor, around_factor, {lit, shaded});
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(factors.sun[c], sun_factor[c], 1.5 * factors.sun_sigma[c]) << c;
    EXPECT_NEAR(factors.around[c], around_factor[c], 1.5 * factors.around_sigma[c]) << c;
    EXPECT_GT(std::abs(factors.around[c] - 1.0), 0.4 * std::abs(around_factor[c] - 1.0)) << "the model alone is 1";
  }
  const auto shade_alone = found(sun_factor, around_factor, {shaded});
  EXPECT_GT(shade_alone.sun_sigma.g, factors.sun_sigma.g) << "it does not see the sun";
  EXPECT_NEAR(shade_alone.around.g, factors.around.g, 0.06);
}

TEST_F(CardsInView, AreNotBelievedInAShadowThatNobodyToldOf) {
  const auto factors = found(glm::dvec3{0.0}, glm::dvec3{1.0}, {lit, shaded});
  for (int c = 0; c < 3; ++c) {
    EXPECT_GT(factors.sun[c], 0.85);
    EXPECT_GT(factors.around[c], 0.85);
  }
}

// Of a wall of which only its being grey is known: a reflectance of .25 and one of .65, about .4.
struct GreyCardsInView : CardsInView {
  LightFactors found_by_grey(const glm::dvec3& sun_factor, const glm::dvec3& around_factor, double exposure = 0.02,
                             const glm::dvec3& lit_by_sun = glm::dvec3{1.0}) const {
    const auto behind = horizon(exposure, {0.7, 1.0, 1.2});
    std::vector<CardReading> readings;
    for (auto card : {lit, shaded}) {
      card.reflectance = glm::dvec3{card.name == "lit" ? 0.65 : 0.25};
      const auto light = model_light(card, sun_factor * lit_by_sun, around_factor);
      card.reflectance = glm::dvec3{kGreyReflectance};
      card.grey = true;
      const auto towards = towards_card(card, camera, behind);
      readings.push_back(card_reading(card, light / daylight.airlight(towards), towards, daylight));
    }
    return factors_by_cards(readings);
  }
  // ln of red and blue over green.
  static glm::dvec2 colour(const glm::dvec3& factor) {
    return {std::log(factor.r / factor.g), std::log(factor.b / factor.g)};
  }
};

TEST_F(GreyCardsInView, TellTheColoursOfSunAndSkyWhateverTheyReflect) {
  const glm::dvec3 sun_factor{1.05, 1.0, 0.85}, around_factor{0.8, 1.0, 1.2};
  const auto factors = found_by_grey(sun_factor, around_factor);
  const auto sun_off = colour(factors.sun) - colour(sun_factor);
  const auto around_off = colour(factors.around) - colour(around_factor);
  for (int c = 0; c < 2; ++c) {
    EXPECT_LT(std::abs(sun_off[c]), 0.8 * std::abs(colour(sun_factor)[c]) + 0.02)
        << c << ": the model alone is off by all";
    EXPECT_LT(std::abs(around_off[c]), 0.45 * std::abs(colour(around_factor)[c])) << c;
  }
  EXPECT_NEAR(factors.around.g, 1.0, 0.1) << "a dark wall is no little light";
  EXPECT_NEAR(factors.sun.g, 1.0, 0.1);
  const auto alone = found_by_grey(glm::dvec3{1.0}, glm::dvec3{1.0});
  EXPECT_LT(glm::length(colour(alone.sun)) + glm::length(colour(alone.around)), 0.02) << "the model is right";
}

TEST_F(GreyCardsInView, ShowTheSkysLightWhereAShadowLiesOnThem) {
  const glm::dvec3 around_factor{0.8, 1.0, 1.2};
  const auto factors = found_by_grey(glm::dvec3{1.0}, around_factor, 0.02, glm::dvec3{0.0});
  EXPECT_LT(glm::length(colour(factors.around) - colour(around_factor)), 0.2 * glm::length(colour(around_factor)));
  EXPECT_LT(glm::length(colour(factors.sun)), 0.6 * glm::length(colour(around_factor))) << "of the sun they say little";
}

TEST(LightByCards, OfOneKnownCardIsTheMeanOfModelAndCard) {
  const CardReading reading{{1.2, 1.0, 0.9}, {0.7, 0.7, 0.7}};
  const auto factors = factors_by_cards(std::vector{reading});
  // Variances .02 of the model, .01 in common, .07^2 of the card.
  const double with_sun = 0.7 * 0.02 + 0.3 * 0.01, with_around = 0.7 * 0.01 + 0.3 * 0.02;
  const double gain = 1.0 / (0.7 * with_sun + 0.3 * with_around + 0.0049);
  EXPECT_NEAR(factors.sun.r, 1.0 + 0.2 * with_sun * gain, 1e-12);
  EXPECT_NEAR(factors.around.b, 1.0 - 0.1 * with_around * gain, 1e-12);
  EXPECT_EQ(factors.sun.g, 1.0);
}

TEST_F(CardsInView, SayNothingWhereTheyAreClippedOrThereIsNoHorizon) {
  Image<Rgb8> white(kWidth, kHeight);
  for (auto& pixel : white.elements()) pixel = Rgb8(255);
  EXPECT_FALSE(card_over_horizon(lit, camera, view_of(white), horizon(0.02, glm::dvec3{1.0}), 1.0));
  Image<Rgb8> grey(kWidth, kHeight);
  for (auto& pixel : grey.elements()) pixel = Rgb8(90);
  EXPECT_FALSE(card_over_horizon(lit, camera, view_of(grey), {}, 1.0));
  EXPECT_TRUE(card_over_horizon(lit, camera, view_of(grey), horizon(0.02, glm::dvec3{1.0}), 1.0));
}

TEST_F(CardsInView, AreSeenWithoutTheCamerasSaturation) {
  Image<Rgb8> grey(kWidth, kHeight);
  for (auto& pixel : grey.elements()) pixel = Rgb8(90);
  const auto blue = horizon(0.02, {0.6, 1.0, 1.5});
  const auto plain = card_over_horizon(lit, camera, view_of(grey), blue, 1.0).value();
  const auto saturated = card_over_horizon(lit, camera, view_of(grey), blue, 1.8).value();
  EXPECT_GT(plain.r / plain.b, saturated.r / saturated.b) << "the horizon was less blue than it is shown";
}

TEST(LightByCards, IsTheModelsWithoutAny) {
  const auto factors = factors_by_cards({});
  EXPECT_EQ(factors.sun, glm::dvec3{1.0});
  EXPECT_EQ(factors.around, glm::dvec3{1.0});
}

}  // namespace
}  // namespace kasumi
