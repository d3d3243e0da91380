// Rotations between pairs of directions.
#pragma once

#include <optional>

#include <glm/glm.hpp>

namespace kasumi {

// The rotation that best maps the unit vectors a, b to to_a, to_b: exact for the bisector and the plane of the pair.
// Empty when either pair is closer to parallel than `min_sine`, the sine of the angle between its directions.
std::optional<glm::dmat3> rotation_between(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& to_a,
                                           const glm::dvec3& to_b, double min_sine);

}  // namespace kasumi
