#include "calib/lens_fisheye.hpp"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace kasumi {
namespace {
// The rim itself belongs to the picture: rounding must not push it out.
constexpr double kRimTolerance = 1e-9;
}  // namespace

FisheyeLens::FisheyeLens(glm::dvec2 centre, const glm::dmat2& pixels_from_plane, double largest_angle,
                         double largest_radius)
    : centre_(centre),
      pixels_from_plane_(pixels_from_plane),
      plane_from_pixels_(glm::inverse(pixels_from_plane)),
      largest_angle_(largest_angle),
      largest_radius_(largest_radius) {}

std::optional<glm::dvec2> FisheyeLens::project(const glm::dvec3& ray) const {
  const double off_axis = std::hypot(ray.x, ray.y);
  if (off_axis == 0.0) {
    if (ray.z > 0.0) return centre_;
    return std::nullopt;  // straight behind is a whole circle of pixels, and no ray at all is nowhere
  }
  const double from_axis = std::atan2(off_axis, ray.z);
  if (!(from_axis <= largest_angle_ + kRimTolerance)) return std::nullopt;
  const double r = radius(std::min(from_axis, largest_angle_));
  return centre_ + pixels_from_plane_ * (r / off_axis * glm::dvec2{ray.x, ray.y});
}

std::optional<glm::dvec3> FisheyeLens::unproject(const glm::dvec2& pixel) const {
  const glm::dvec2 point = plane_from_pixels_ * (pixel - centre_);
  const double r = glm::length(point);
  if (r == 0.0) return glm::dvec3{0.0, 0.0, 1.0};
  if (!(r <= largest_radius_ * (1.0 + kRimTolerance))) return std::nullopt;
  const double from_axis = angle(std::min(r, largest_radius_));
  return glm::dvec3{std::sin(from_axis) / r * point, std::cos(from_axis)};
}

}  // namespace kasumi
