// The sun as the saturated blob of a sky picture: a second opinion on the ephemeris, and the only one while the clock
// is not to be trusted.
#pragma once

#include <optional>
#include <string>

#include <glm/vec2.hpp>

#include "base/saturation.hpp"
#include "base/units.hpp"
#include "calib/camera.hpp"
#include "estimator/atmosphere.hpp"
#include "estimator/turbidity/sky_picture.hpp"

namespace kasumi {

struct SunBlob {
  SunDirection direction{0.0, 0.0, 1.0};
  glm::dvec2 pixel{};       // of the camera's picture, sub-pixel
  Radians radius;           // of a cap of the same solid angle
  double confidence = 0.0;  // 0..1: roundness, contrast with its surroundings, lack of rivals
};

struct SunBlobOptions {
  double saturated = kSaturatedSun;             // encoded level that the dimmest channel reaches: the core is white
  Radians smallest_radius = from_degrees(0.1);  // the sun's own is 0.27 deg; a lens spreads it, never shrinks it
  Radians largest_radius = from_degrees(25.0);  // wider: a bright cloud, a white-out
  double least_confidence = 0.3;
};

// The most sun-like saturated region above the horizon, or none. Reflections on the dome or on buildings lose by size,
// shape and a missing halo.
std::optional<SunBlob> find_sun(const SkyPicture& picture, const Camera& camera, const SunBlobOptions& options = {});

enum class SunSource { none, ephemeris, image };
struct SunCheck {
  SunSource source = SunSource::none;
  SunDirection direction{0.0, 0.0, 1.0};  // valid unless source is none
  std::optional<Radians> disagreement;    // between the two, when both are known
  bool agrees = false;                    // both are known and within the tolerance
  std::string words;                      // for a person: "the sun in the image is 0.4 deg from the ephemeris"
};

// With a trusted clock the ephemeris wins (it is a thousand times more precise), and a disagreement speaks of the
// camera's orientation. Without, the image wins, and a sun that is not seen is not known.
SunCheck cross_check(const std::optional<SunDirection>& ephemeris, const std::optional<SunBlob>& blob,
                     bool clock_trusted, Radians tolerance = from_degrees(3.0));

}  // namespace kasumi
