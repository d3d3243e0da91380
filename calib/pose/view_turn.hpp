// Rotation of a camera between two of its pictures, from what is static in both.
#pragma once

#include <optional>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "base/units.hpp"
#include "calib/lens/lens.hpp"
#include "calib/pose/view_lines.hpp"

namespace kasumi {

struct ViewTurn {
  // Rotation vector of the scene about the camera's axes, radians. Positive x: the scene moved up, the camera down;
  // y: the scene to the right, the camera to the left; z: the scene turned clockwise in the picture.
  glm::dvec3 turn{0.0};
  glm::dmat3 covariance{0.0};
  double agreement = 0.0;  // share of the parts of the picture with structure that are unchanged: 0..1
  int parts = 0;           // parts with structure
  Radians angle() const;   // of the whole turn
  Radians sigma() const;   // of that angle, one standard deviation
};

// Where a direction in the camera's frame appears after the turn.
glm::dvec3 turned(const ViewTurn& turn, const glm::dvec3& ray);

// By the lines of both pictures; parts that differ (clouds, people, shadows) are outliers. The rotation is about the
// camera's centre and all three axes, through its own lens (robust Lucas-Kanade least squares from coarse to fine). For
// the covariance each part of the picture is one observation, since the errors of neighbouring pixels are correlated.
// Empty: too little structure in either picture, or nothing is unchanged.
std::optional<ViewTurn> find_turn(const Lens& lens, const ViewLines& reference, const ViewLines& now);

}  // namespace kasumi
