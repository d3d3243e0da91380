// The sun as the saturated blob of a sky picture: a check of the ephemeris, and the only source while the clock is not
// trusted.
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
  Radians radius;           // of a cap with the same solid angle
  double confidence = 0.0;  // 0..1: roundness, contrast with its surroundings, lack of rivals
};

struct SunBlobOptions {
  double saturated = kSaturatedSun;  // encoded level that the dimmest channel must reach: the sun's core is white
  Radians smallest_radius = from_degrees(0.1);  // the sun's own is 0.27 deg; a lens spreads it, never shrinks it
  Radians largest_radius = from_degrees(25.0);  // larger: a bright cloud, or an overexposed sky
  double least_confidence = 0.3;
};

// The most sun-like saturated region above the horizon, or none. Reflections on the dome or on buildings score lower by
// size, shape and a missing aureole.
std::optional<SunBlob> find_sun(const SkyPicture& picture, const Camera& camera, const SunBlobOptions& options = {});

enum class SunSource { none, ephemeris, image };
struct SunCheck {
  SunSource source = SunSource::none;
  SunDirection direction{0.0, 0.0, 1.0};  // valid unless source is none
  std::optional<Radians> disagreement;    // between the two, when both are known
  bool agrees = false;                    // both are known and within the tolerance
  std::string message;                    // for people: "the sun in the image is 0.4 deg from the ephemeris"
};

// With a trusted clock the ephemeris is used (it is a thousand times more precise), and a disagreement points to the
// camera's orientation. Otherwise the image is used; if the sun is not visible in it, its direction is unknown.
SunCheck cross_check(const std::optional<SunDirection>& ephemeris, const std::optional<SunBlob>& blob,
                     bool clock_trusted, Radians tolerance = from_degrees(3.0));

}  // namespace kasumi
