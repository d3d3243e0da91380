// Dirt on the sky camera's dome: spots that stay darker than the surrounding sky while the sky changes.
#pragma once

#include <span>
#include <vector>

#include <glm/vec2.hpp>

#include "base/image.hpp"
#include "base/picture.hpp"

namespace kasumi {

// One frame of the sky, downsampled: linear red, green and blue light.
using DomeFrame = Image<glm::vec3>;

struct DomeSpot {
  glm::dvec2 place{};    // its middle, in elements of the shrunk picture
  double area = 0.0;     // share of the elements that were checked, 0..1
  double dimming = 0.0;  // of the light, at its darkest: 0..1
};
struct DomeState {
  std::vector<DomeSpot> spots;  // the darkest first
  double looked_at = 0.0;       // share of the unmasked elements that could be checked
  double least_dimming = 0.0;   // smallest dimming that would have been detected
};

// How much dimmer than its surroundings each part of a sky already was, where the sky about it was smooth; else 0. In
// steps of 2 % of the light.
struct DomeShade {
  static constexpr int kSteepest = 35;
  static constexpr double kStep = 0.02;
  Image<std::uint8_t> steps;  // 0 to kSteepest
};
// `usable` as below.
DomeShade shade_of(const DomeFrame& frame, const Image<std::uint8_t>& usable);

// A spot is darker than its surroundings (some 11 deg about) by more than the noise and 8 % in four of five of those
// frames in which the sky about it was smooth (four at least), not bluer than they are (a gap between clouds is), and
// was not so in the reference. `usable`, of the frames' size: 0 near the sun, near obstructions, near the horizon. Of
// fewer than 8 frames nothing is judged (looked_at is 0).
DomeState find_spots(std::span<const DomeFrame> frames, const DomeShade& reference, const Image<std::uint8_t>& usable);

}  // namespace kasumi
