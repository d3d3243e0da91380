#include "estimator/light/card_light.hpp"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "base/square.hpp"
#include "calib/colour/camera_saturation.hpp"

namespace kasumi {
namespace {

// The model's factors on sun and surroundings: variance .02 each, half of it shared; sigma of a reading: .07.
constexpr double kModelVariance = 0.02, kModelTogether = 0.01, kCardSigma = 0.07;

}  // namespace

Direction towards_card(const LightCard& card, const Camera& scene, const HorizonLight& horizon) {
  const auto view = scene.direction_at({card.x + 0.5 * (card.width - 1), card.y + 0.5 * (card.height - 1)});
  const auto column = column_at(horizon, azimuth_angle(view.value_or(scene.to_world * glm::dvec3{0, 0, 1})));
  return direction_from(column.zenith, column.azimuth);
}

std::optional<glm::dvec3> card_over_horizon(const LightCard& card, const Camera& scene, const PictureView& picture,
                                            const HorizonLight& horizon, double saturation) {
  constexpr int kWhite = 254;  // JPEG and sharpening leave clipped white at 254 or 255
  // Chosen: a clipped mean reads too dark; a twentieth changes it by less than kCardSigma.
  constexpr double kClippedShare = 0.05;
  if (!horizon.usable() || card.x + card.width > picture.width || card.y + card.height > picture.height)
    return std::nullopt;
  glm::dvec3 sum{0.0};
  int clipped = 0;
  for (int y = card.y; y < card.y + card.height; ++y)
    for (int x = card.x; x < card.x + card.width; ++x) {
      const auto code = rgb_at(picture, x, y);
      if (std::max({code.r, code.g, code.b}) >= kWhite) ++clipped;
      sum += scene.light_at({x, y}, glm::dvec3(code) / 255.0);
    }
  const int count = card.width * card.height;
  if (clipped > kClippedShare * count) return std::nullopt;
  const auto unsaturated = [&](const glm::dvec3& light) {
    return with_saturation(light * scene.white_balance, 1.0 / saturation);
  };
  const auto towards = towards_card(card, scene, horizon);
  const glm::dvec3 seen = unsaturated(sum / static_cast<double>(count));
  const glm::dvec3 behind = unsaturated(column_at(horizon, azimuth_angle(towards)).light);
  if (!(std::min({seen.r, seen.g, seen.b}) > 0.0) || !(std::min({behind.r, behind.g, behind.b}) > 0.0))
    return std::nullopt;
  return seen / behind;
}

CardReading card_reading(const LightCard& card, const glm::dvec3& over_horizon, const Direction& towards,
                         const Daylight& daylight) {
  const LightOnObject& light = daylight.on_object();
  const glm::dvec3 sun = std::max(0.0, glm::dot(card.normal, light.sun_direction)) * light.sun_irradiance;
  const glm::dvec3 all = glm::max(sun + irradiance(light.around, card.normal), glm::dvec3{1e-12});
  return {over_horizon * daylight.airlight(towards) * kPi / (card.reflectance * all), sun / all};
}

LightFactors factors_by_cards(std::span<const CardReading> readings) {
  LightFactors factors;
  for (int c = 0; c < 3; ++c) {
    double sun = 1.0, around = 1.0;
    double variance_sun = kModelVariance, variance_around = kModelVariance, together = kModelTogether;
    for (const CardReading& reading : readings) {
      const double share = reading.sun_share[c], rest = 1.0 - share, seen = reading.over_model[c];
      const double with_sun = share * variance_sun + rest * together;
      const double with_around = share * together + rest * variance_around;
      const double expected = share * sun + rest * around, known = share * with_sun + rest * with_around;
      // As of a distribution with long tails.
      const double off = square(seen - expected) / (known + square(kCardSigma)),
                   doubt = std::max(1.0, std::pow(off / 9.0, 3.0));
      const double variance = known + doubt * square(kCardSigma);
      sun += with_sun / variance * (seen - expected);
      around += with_around / variance * (seen - expected);
      variance_sun -= square(with_sun) / variance;
      variance_around -= square(with_around) / variance;
      together -= with_sun * with_around / variance;
    }
    // Beyond the models' own errors by far: then the card is wrong, not the light.
    constexpr double kLeast = 0.5, kMost = 2.0;
    factors.sun[c] = std::clamp(sun, kLeast, kMost);
    factors.around[c] = std::clamp(around, kLeast, kMost);
    factors.sun_sigma[c] = std::sqrt(std::max(0.0, variance_sun));
    factors.around_sigma[c] = std::sqrt(std::max(0.0, variance_around));
  }
  return factors;
}

}  // namespace kasumi
