#include "calib/camera.hpp"

#include "calib/colour/colorimetry.hpp"

namespace kasumi {

std::optional<Direction> Camera::direction_at(const glm::dvec2& pixel) const {
  const auto ray = lens->unproject(pixel);
  if (!ray) return std::nullopt;
  return to_world * *ray;
}

std::optional<glm::dvec2> Camera::pixel_of(const Direction& direction) const {
  return lens->project(direction * to_world);  // row vector times rotation: its transpose, world to camera
}

glm::dvec3 Camera::light_at(const glm::dvec2& pixel, const glm::dvec3& encoded) const {
  return response.to_light(encoded) / (vignetting.at(pixel) * white_balance);
}

glm::dmat3 Camera::light_to_xyz() const {
  return colour_space == ColourSpace::sensor ? camera_to_xyz(sensitivity) : srgb_to_xyz();
}

}  // namespace kasumi
