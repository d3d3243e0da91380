#include "estimator/light/card_light.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "base/square.hpp"
#include "calib/colour/camera_saturation.hpp"

namespace kasumi {
namespace {

// The model's factors on sun and surroundings: variance .02 each, half of it shared; sigma of a reading: .07.
constexpr double kModelVariance = 0.02, kModelTogether = 0.01, kCardSigma = 0.07;
// Of a grey card: ln of its reflectance, about kGreyReflectance.
constexpr double kGreySigma = 0.5;

// What is believed of the factors on the model's light, as a normal distribution.
class LightState {
 public:
  LightState() {
    mean_.fill(1.0);
    for (int c = 0; c < 3; ++c) {
      at(sun(c), sun(c)) = at(around(c), around(c)) = kModelVariance;
      at(sun(c), around(c)) = at(around(c), sun(c)) = kModelTogether;
    }
    mean_[kAmount] = 0.0;
  }

  void learn(int c, double seen, double share) {
    const Gain gain = by({{sun(c), share}, {around(c), 1.0 - share}});
    const double expected = share * mean_[sun(c)] + (1.0 - share) * mean_[around(c)];
    // As of a distribution with long tails.
    const double off = square(seen - expected) / (gain.variance + square(kCardSigma)),
                 doubt = std::max(1.0, std::pow(off / 9.0, 3.0));
    update(gain, seen - expected, doubt * square(kCardSigma));
  }

  // How far a grey card is from what is expected of it: -2 ln of its likelihood.
  double surprise(const glm::dvec3& seen, const glm::dvec3& sun_share) const {
    LightState after = *this;
    return after.learn_logarithms(seen, sun_share, 1.0);
  }
  void learn_grey(const glm::dvec3& seen, const glm::dvec3& sun_share) {
    // Of three channels, 99 % are within 11.3.
    constexpr double kUsual = 11.3;
    learn_logarithms(seen, sun_share, std::max(1.0, std::pow(surprise(seen, sun_share) / kUsual, 3.0)));
  }

  LightFactors factors() const {
    // Beyond the models' own errors by far: then the card is wrong, not the light.
    constexpr double kLeast = 0.5, kMost = 2.0;
    LightFactors found;
    for (int c = 0; c < 3; ++c) {
      found.sun[c] = std::clamp(mean_[sun(c)], kLeast, kMost);
      found.around[c] = std::clamp(mean_[around(c)], kLeast, kMost);
      found.sun_sigma[c] = std::sqrt(std::max(0.0, at(sun(c), sun(c))));
      found.around_sigma[c] = std::sqrt(std::max(0.0, at(around(c), around(c))));
    }
    return found;
  }

 private:
  static constexpr std::size_t kAmount = 6, kStates = 7;  // the last: ln of a grey card's reflectance
  static std::size_t sun(int c) { return static_cast<std::size_t>(2 * c); }
  static std::size_t around(int c) { return static_cast<std::size_t>(2 * c + 1); }
  double& at(std::size_t i, std::size_t k) { return covariance_[i * kStates + k]; }
  double at(std::size_t i, std::size_t k) const { return covariance_[i * kStates + k]; }

  struct Gain {
    std::array<double, kStates> with{};  // covariance with what is seen
    double variance = 0.0;               // of that, by the state alone
  };
  Gain by(std::initializer_list<std::pair<std::size_t, double>> slopes) const {
    Gain gain;
    for (std::size_t i = 0; i < kStates; ++i)
      for (const auto& [k, slope] : slopes) gain.with[i] += slope * at(i, k);
    for (const auto& [k, slope] : slopes) gain.variance += slope * gain.with[k];
    return gain;
  }
  void update(const Gain& gain, double off, double reading_variance) {
    const double variance = gain.variance + reading_variance;
    for (std::size_t i = 0; i < kStates; ++i) mean_[i] += gain.with[i] / variance * off;
    for (std::size_t i = 0; i < kStates; ++i)
      for (std::size_t k = 0; k < kStates; ++k) at(i, k) -= gain.with[i] * gain.with[k] / variance;
  }
  double learn_logarithms(const glm::dvec3& seen, const glm::dvec3& sun_share, double doubt) {
    constexpr double kLeast = 0.05;  // of the model's light: what is darker is not lit by it
    mean_[kAmount] = 0.0;
    at(kAmount, kAmount) = square(kGreySigma);
    double surprise = 0.0;
    for (int c = 0; c < 3; ++c) {
      const double share = sun_share[c];
      const double light = std::max(kLeast, share * mean_[sun(c)] + (1.0 - share) * mean_[around(c)]);
      const Gain gain = by({{sun(c), share / light}, {around(c), (1.0 - share) / light}, {kAmount, 1.0}});
      const double off = std::log(std::max(kLeast, seen[c])) - std::log(light) - mean_[kAmount];
      const double reading = doubt * square(kCardSigma);
      surprise += square(off) / (gain.variance + reading) + std::log(gain.variance + reading);
      update(gain, off, reading);
    }
    for (std::size_t i = 0; i < kStates; ++i) at(i, kAmount) = at(kAmount, i) = 0.0;
    return surprise;
  }

  std::array<double, kStates> mean_{};
  std::array<double, kStates * kStates> covariance_{};
};

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
  const glm::dvec3 around = glm::max(irradiance(light.around, card.normal), glm::dvec3{1e-12}), all = sun + around;
  const glm::dvec3 reflected = over_horizon * daylight.airlight(towards) * kPi / card.reflectance;
  CardReading reading{reflected / all, sun / all, card.grey};
  if (card.grey) reading.in_shadow = reflected / around;
  return reading;
}

LightFactors factors_by_cards(std::span<const CardReading> readings) {
  LightState state;
  for (const CardReading& reading : readings) {
    if (!reading.grey) {
      for (int c = 0; c < 3; ++c) state.learn(c, reading.over_model[c], reading.sun_share[c]);
      continue;
    }
    const bool shadow = reading.in_shadow && state.surprise(*reading.in_shadow, glm::dvec3{0.0}) <
                                                 state.surprise(reading.over_model, reading.sun_share);
    state.learn_grey(shadow ? *reading.in_shadow : reading.over_model, shadow ? glm::dvec3{0.0} : reading.sun_share);
  }
  return state.factors();
}

}  // namespace kasumi
