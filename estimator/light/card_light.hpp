// Light on cards of known reflectance in the scene camera's view, by which the model's light on the object, in units of
// its light at the horizon, is corrected: sun and sky apart, channel by channel.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "base/geometry.hpp"
#include "base/picture.hpp"
#include "calib/camera.hpp"
#include "estimator/horizon/horizon.hpp"
#include "estimator/light/object_light.hpp"

namespace kasumi {

// A card, a wall, a boulder so near that air does not matter.
struct LightCard {
  std::string name;
  int x = 0, y = 0, width = 1, height = 1;  // pixels of the scene camera's picture that show nothing else
  glm::dvec3 reflectance{0.0};              // in the camera's channels, dull; of a grey one the likeliest
  Direction normal{0, 0, 1};                // where it faces, world
  bool grey = false;                        // all channels alike; how much it reflects is not known
};
constexpr double kGreyReflectance = 0.4;  // the likeliest of plaster, concrete, stone, metal roofs: .2 to .8

// The card's mean light over the horizon's in that direction. `saturation`: of the camera (calib/colour/camera_saturation),
// which is taken back. Nothing: clipped, black, or no horizon.
std::optional<glm::dvec3> card_over_horizon(const LightCard& card, const Camera& scene, const PictureView& picture,
                                            const HorizonLight& horizon, double saturation);

// What a card says: how many times as bright it is as by the model, and the sun's share of the model's light on it.
struct CardReading {
  glm::dvec3 over_model{1.0}, sun_share{0.0};
  bool grey = false;                      // `over_model` is so but for one factor that its channels share
  std::optional<glm::dvec3> in_shadow{};  // of a grey one: `over_model` if a shadow lies on it
};
// `towards`: as for card_over_horizon, which found `over_horizon`.
CardReading card_reading(const LightCard& card, const glm::dvec3& over_horizon, const Direction& towards,
                         const Daylight& daylight);
Direction towards_card(const LightCard& card, const Camera& scene, const HorizonLight& horizon);

// To be multiplied on the model's light of the sun and of sky and ground.
struct LightFactors {
  glm::dvec3 sun{1.0}, around{1.0};
  glm::dvec3 sun_sigma{0.0}, around_sigma{0.0};  // one standard deviation
};
// The model's own, +- 14 % each, half of its variance in common, with every reading, +- 7 %, as a normal distribution.
// A reading off by more than three standard deviations (such as a card in an unknown shadow) counts less. A grey card says
// what colour the light has; whether a shadow lies on it is decided by what explains it better.
LightFactors factors_by_cards(std::span<const CardReading> readings);

}  // namespace kasumi
