// Lens models: between pixels and rays of the camera frame (x right, y down, z along the optical axis).
// Pixel coordinates: the centre of the top left pixel is (0, 0).
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "base/result.hpp"
#include "base/table/config_table.hpp"
#include "base/units.hpp"

namespace kasumi {

class Lens {
 public:
  virtual ~Lens() = default;
  virtual std::string_view name() const = 0;  // as written in the configuration
  // Where a ray (any length) is seen; empty when the model does not reach it (behind a pinhole, beyond the fisheye's
  // largest angle).
  virtual std::optional<glm::dvec2> project(const glm::dvec3& ray) const = 0;
  // The unit ray a pixel sees; empty outside the model's reach.
  virtual std::optional<glm::dvec3> unproject(const glm::dvec2& pixel) const = 0;
};

using LensPtr = std::shared_ptr<const Lens>;

// r = f theta
LensPtr equidistant_lens(glm::dvec2 centre, double focal_px, Radians largest_angle);
// r = 2 f sin(theta / 2)
LensPtr equisolid_lens(glm::dvec2 centre, double focal_px, Radians largest_angle);
// The same for pictures that are turned over, left to right.
LensPtr mirrored_lens(LensPtr lens);
// OpenCV's fisheye model: theta_d = theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8)
LensPtr opencv_fisheye_lens(glm::dvec2 focal_px, glm::dvec2 centre, std::array<double, 4> k, Radians largest_angle);
// Scaramuzza's (OCamCalib's) model, in OCamCalib's own terms: from the centre a pixel lies c v + d u rows down and
// e v + u columns right, and sees (right, down, forward) = (u, v, -(a0 + a1 rho + a2 rho^2 + ...)), rho = |(u, v)|.
struct ScaramuzzaParameters {
  std::vector<double> polynomial;  // a0, a1, a2, ... in pixels; a0 < 0, for OCamCalib's z axis points into the camera
  glm::dvec2 centre{};             // column, row; the centre of the top left pixel is (0, 0)
  double c = 1.0, d = 0.0, e = 0.0;
  int width = 0, height = 0;  // of the calibration's pictures; 0: not known
};
LensPtr scaramuzza_lens(ScaramuzzaParameters model, Radians largest_angle);

// Pinhole with Brown's radial and tangential distortion, as OpenCV orders it: k1 k2 p1 p2 k3.
struct PinholeParameters {
  glm::dvec2 focal_px{};
  glm::dvec2 centre{};
  std::array<double, 5> distortion{};
};
LensPtr pinhole_lens(const PinholeParameters& model);
// The model behind a pinhole lens, for the renderer's projection; empty for every other lens.
std::optional<PinholeParameters> pinhole_model(const Lens& lens);

// The text file OCamCalib exports (calib_results.txt). Its inverse polynomial is ignored: it is an approximation.
Result<ScaramuzzaParameters> read_ocamcalib(const std::filesystem::path& path);

// [lens] of a camera. Problems are recorded in the table; the result is then some valid lens, so that reading can go
// on. Keys by model (docs/cameras.md), fisheyes also largest_angle_deg (default 90, or fov_deg / 2)
// and mirrored (default false; the picture is turned over, left to right):
//   model = "equidistant" | "equisolid":  focal_px = f, centre_px = [x, y]  or  fov_deg, circle_px = [x, y, radius]
//   model = "opencv_fisheye":             focal_px = [fx, fy], centre_px, k = [k1, k2, k3, k4]
//   model = "scaramuzza":                 polynomial = [a0, ...], centre_px, affine = [c, d, e]  or  ocamcalib = "FILE"
//   model = "pinhole":                    focal_px = [fx, fy], centre_px, distortion = [k1, k2, p1, p2, k3]
LensPtr read_lens(const ConfigTable& table);

}  // namespace kasumi
