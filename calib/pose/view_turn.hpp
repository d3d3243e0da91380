// Rotation of a camera between two of its pictures, from the static content of both.
#pragma once

#include <optional>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "base/image.hpp"
#include "base/units.hpp"
#include "calib/lens/lens.hpp"

namespace kasumi {

// A camera's picture in linear light, shrunk by a whole factor (each element the mean of its pixels).
struct ShrunkView {
  Image<float> light;
  int factor = 1;
  Image<std::uint8_t> usable;  // 0: nothing of use there (outside the image circle, open sky); empty: all of it
  glm::dvec2 pixel(double x, double y) const { return (glm::dvec2{x, y} + 0.5) * double(factor) - 0.5; }
};

struct ViewTurn {
  // Of what is seen, about the camera's axes, radians: x positive: it moved up, so the camera down; y: it moved to the
  // right, the camera to the left; z: it turned clockwise in the picture.
  glm::dvec3 turn{0.0};
  glm::dmat3 covariance{0.0};
  double agreement = 0.0;  // of the parts of the picture with something in them, how many look as before: 0..1
  int parts = 0;           // how many parts those are
  Radians angle() const;   // of the whole turn
  Radians sigma() const;   // of that angle, one standard deviation
};

// Where a direction of the camera's frame is seen after the turn.
glm::dvec3 turned(const ViewTurn& turn, const glm::dvec3& ray);

// The pictures are compared as patterns, each part relative to its own mean and contrast, so that weather, light and
// exposure do little; what differs (clouds, people, shadows) is left out as an outlier. The turn is that of a camera
// about its own centre, about all three axes, through its own lens (Lucas and Kanade's least squares from coarse to
// fine, robust). The covariance is that of the sums over parts of the picture, each taken as one observation, since
// neighbours err alike. Empty: too little in either to compare, or nothing looks as before.
std::optional<ViewTurn> find_turn(const Lens& lens, const ShrunkView& reference, const ShrunkView& now);

}  // namespace kasumi
