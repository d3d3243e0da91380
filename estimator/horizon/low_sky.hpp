// The clear sky from the horizon upwards in the scene camera's picture: what its light says of the air.
#pragma once

#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "base/geometry.hpp"
#include "base/picture.hpp"
#include "base/units.hpp"
#include "calib/camera.hpp"

namespace kasumi {

// Below .5 deg refraction and faded hills count, above 15 a scene camera rarely looks.
constexpr Radians kLowestLowSky = from_degrees(0.5), kHighestLowSky = from_degrees(15.0);

// Light of a small patch of sky.
struct HorizonPatch {
  Direction direction{0.0, 0.0, 1.0};
  glm::dvec3 light{0.0};  // linear, the camera's channels and scale (Camera::light_at)
  glm::dvec3 sigma{0.0};  // relative, by noise and quantisation
  double off_axis = 0.0;  // from the picture's centre, 1 in its corners
};

struct LowSky {
  std::vector<HorizonPatch> patches;  // empty: there is none to be read, and `reason` says why
  std::string reason;                 // for people: "clouds at the horizon"
};

// Of sky that shows neither clouds nor hills. A uniform cloud cover is not detected here; its light fits no clear sky,
// so that it fails the fit later.
LowSky read_low_sky(const Camera& scene, const PictureView& picture);

}  // namespace kasumi
