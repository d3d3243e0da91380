// Base of the fisheye models: the angle from the axis gives a radius in a plane, which an affine map takes to pixels.
#pragma once

#include <glm/mat2x2.hpp>

#include "calib/lens/lens.hpp"

namespace kasumi {

class FisheyeLens : public Lens {
 public:
  std::optional<glm::dvec2> project(const glm::dvec3& ray) const final;
  std::optional<glm::dvec3> unproject(const glm::dvec2& pixel) const final;

 protected:
  // radius(angle) must increase from 0 at angle 0 to largest_radius at largest_angle.
  FisheyeLens(glm::dvec2 centre, const glm::dmat2& pixels_from_plane, double largest_angle, double largest_radius);

 private:
  virtual double radius(double angle) const = 0;  // angle in radians, 0 .. largest_angle
  virtual double angle(double radius) const = 0;  // radius in 0 .. largest_radius

  glm::dvec2 centre_;
  glm::dmat2 pixels_from_plane_;
  glm::dmat2 plane_from_pixels_;
  double largest_angle_;
  double largest_radius_;
};

}  // namespace kasumi
