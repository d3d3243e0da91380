#include "base/geometry.hpp"

#include <cmath>

#include <glm/geometric.hpp>

namespace kasumi {

Direction direction_from(Radians zenith, Radians azimuth) {
  const double s = std::sin(zenith.value);
  return {s * std::sin(azimuth.value), s * std::cos(azimuth.value), std::cos(zenith.value)};
}

Radians zenith_angle(const Direction& direction) {
  return {std::atan2(std::hypot(direction.x, direction.y), direction.z)};
}

Radians azimuth_angle(const Direction& direction) {
  if (direction.x == 0.0 && direction.y == 0.0) return {0.0};
  const double azimuth = std::atan2(direction.x, direction.y);
  return {azimuth < 0.0 ? azimuth + 2.0 * kPi : azimuth};
}

Radians angle_between(const glm::dvec3& a, const glm::dvec3& b) {
  return {std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b))};
}

Direction raised_to_horizon(const Direction& direction) {
  if (direction.z >= 0.0) return direction;
  const double flat = std::hypot(direction.x, direction.y);
  return flat > 0.0 ? Direction{direction.x / flat, direction.y / flat, 0.0} : Direction{0.0, 1.0, 0.0};
}

glm::dmat3 camera_to_world(Radians heading, Radians pitch, Radians roll) {
  const double sh = std::sin(heading.value), ch = std::cos(heading.value);
  const double sp = std::sin(pitch.value), cp = std::cos(pitch.value);
  const glm::dvec3 axis{sh * cp, ch * cp, sp};
  const glm::dvec3 up{-sh * sp, -ch * sp, cp};
  const glm::dvec3 right = glm::cross(axis, up);
  const double sr = std::sin(roll.value), cr = std::cos(roll.value);
  const glm::dvec3 rolled_right = cr * right - sr * up;
  const glm::dvec3 rolled_up = cr * up + sr * right;
  return {rolled_right, -rolled_up, axis};
}

}  // namespace kasumi
