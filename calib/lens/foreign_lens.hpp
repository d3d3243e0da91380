// A lens as another program describes it: its projection by that program's own definition, and one of our models that
// holds it.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "calib/lens/lens_description.hpp"

namespace kasumi {

// To a pixel, whose centre is a whole number; empty: the model does not reach there.
using ForeignProjection = std::function<std::optional<glm::dvec2>(const glm::dvec3& ray)>;

struct ForeignLens {
  std::string program, model;  // "ROS", "equidistant"
  int width = 0, height = 0;   // of the calibration's pictures
  std::optional<double> rms_px;
  ForeignProjection project;
  bool is_fisheye = false;               // it may see beyond 90 deg
  std::optional<LensDescription> exact;  // where one of our models holds it number by number
};

// Affine part of a projection: x = fx u + skew v + cx, y = fy v + cy.
struct SensorMatrix {
  double fx = 0.0, fy = 0.0, cx = 0.0, cy = 0.0, skew = 0.0;
  glm::dvec2 operator()(const glm::dvec2& p) const { return {fx * p.x + skew * p.y + cx, fy * p.y + cy}; }
};

// The plane at z = 1, distorted as OpenCV, ROS and COLMAP define it: k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4, the rest 0.
using BrownCoefficients = std::array<double, 12>;
glm::dvec2 brown_distorted(const glm::dvec2& p, const BrownCoefficients& k);

// OpenCV's pinhole, with whatever skew and as many coefficients.
void set_pinhole(ForeignLens& lens, const SensorMatrix& matrix, const BrownCoefficients& k);
// OpenCV's fisheye, Kannala and Brandt's: r = theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8).
void set_fisheye(ForeignLens& lens, const SensorMatrix& matrix, const std::array<double, 4>& k);
// OpenCV's omnidir, Kalibr's omni, Mei's: a sphere's point, seen from xi behind its middle, distorted as a pinhole's.
void set_omnidirectional(ForeignLens& lens, const SensorMatrix& matrix, double xi, const BrownCoefficients& k);
// Devernay and Faugeras's field of view, as Kalibr and COLMAP have it: r = atan(2 tan(angle) tan(omega / 2)) / omega.
void set_field_of_view(ForeignLens& lens, const SensorMatrix& matrix, double omega);

constexpr double kMostMovedPx = 0.1;

struct HeldLens {
  LensDescription lens;
  double moved_px = 0.0;  // at most, in the calibration's picture; 0: number by number
};

// The lens in our models: as it is, or fitted over the picture up to `largest_angle`: the pinhole's five coefficients,
// or Scaramuzza's polynomial. `wanted`: "auto", or one of our models' names. Errors (bad_input): no model holds it to
// .1 px, with the pixels that it would move.
Result<HeldLens> hold(const ForeignLens& lens, Radians largest_angle, const std::string& wanted);

}  // namespace kasumi
