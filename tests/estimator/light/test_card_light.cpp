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
