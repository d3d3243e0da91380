// The sun in a sky picture: a check of the ephemeris, and the only source while the clock is not trusted.
#pragma once

#include <optional>
#include <string>

#include <glm/vec2.hpp>

#include "base/saturation.hpp"
#include "base/units.hpp"
#include "calib/camera.hpp"
#include "estimator/atmosphere.hpp"
#include "estimator/sky_camera/expected_sun.hpp"
#include "estimator/turbidity/sky_picture.hpp"

namespace kasumi {

struct SunBlob {
  SunDirection direction{0.0, 0.0, 1.0};
  glm::dvec2 pixel{};       // of the camera's picture, sub-pixel
  Radians radius;           // of a cap with the solid angle of what is clipped
  double confidence = 0.0;  // 0..1: probability that it is the sun
  Radians sigma;            // standard deviation along either axis, if it is the sun
};

struct SunBlobLimits {
  double saturated = kSaturatedSun;  // encoded level that the dimmest channel must reach: the sun's core is white
  Radians largest_radius = from_degrees(25.0);           // larger: a bright cloud, or an overexposed sky
  double least_by_aureole = 0.85, least_by_shape = 0.7;  // confidence
  Radians largest_by_aureole = from_degrees(1.75), largest_by_shape = from_degrees(2.5);  // sigma
  // For cameras of which little is known: a bright cloud's edge beside the hidden sun may pass for it.
  bool by_shape = false;
  std::optional<ExpectedSun> expected = std::nullopt;
};

// By the sky around it where that finds the sun, since it is more precise; else, if asked for, by its shape. Empty
// where neither does.
std::optional<SunBlob> find_sun(const SkyPicture& picture, const Camera& camera, const SunBlobLimits& options = {});

// "+- 0.4 deg, 97 % sure"
std::string how_sure(const SunBlob& blob);

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
// `looked`: whether there was an image to find it in.
SunCheck cross_check(const std::optional<SunDirection>& ephemeris, const std::optional<SunBlob>& blob,
                     bool clock_trusted, bool looked = true, Radians tolerance = from_degrees(3.0));

}  // namespace kasumi
