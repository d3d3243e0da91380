// How a camera that looks up was turned about the vertical, and whether its pictures are mirrored, from suns seen in them.
#pragma once

#include <optional>
#include <span>

#include "base/geometry.hpp"
#include "base/units.hpp"

namespace kasumi {

struct SunPair {
  Direction seen{0, 0, 1};   // as if the top of the picture pointed north
  Direction stood{0, 0, 1};  // by time and place
};

struct AzimuthFit {
  Radians azimuth_up{};  // of the picture's top; mirrored pictures: after they were turned over, left to right
  Radians sigma{};
  bool mirrored = false;
  bool mirror_known = false;  // determined by suns at two places; false: assumed not mirrored
  int suns = 0;               // that agree
};

// The turn that most suns agree with, within six degrees: level and lens are not known better. Empty: no sun, or no two
// that agree of several.
std::optional<AzimuthFit> fit_azimuth(std::span<const SunPair> suns);

// The direction in a mirrored picture, and back.
inline Direction mirrored_in_picture(const Direction& seen) {
  return {-seen.x, seen.y, seen.z};
}

}  // namespace kasumi
