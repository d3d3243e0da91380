// The scene camera's pose by least squares over the sights that are used (Ceres), linearised at the solution.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "calib/lens/lens.hpp"
#include "calib/pose/scene_pose.hpp"

namespace kasumi {

struct PoseParameters {
  glm::dmat3 to_world{1.0};
  double log_scale = 0.0;  // over the prior's lens
  glm::dvec3 position_m{0.0};
};
glm::dmat3 rotation_by(const glm::dvec3& axis_angle);  // radians

// The prior's lens, scaled by a number that a fit moves.
class ScaledLens {
 public:
  explicit ScaledLens(const LensDescription& description);
  std::optional<glm::dvec2> project(const glm::dvec3& ray, double log_scale) const;
  std::optional<glm::dvec3> unproject(const glm::dvec2& pixel, double log_scale) const;
  double focal_px() const { return focal_px_; }

 private:
  LensPtr lens_;
  glm::dvec2 centre_;
  double focal_px_;
};

// Landmarks first, then the horizon's points.
struct PoseSights {
  std::span<const LandmarkSight> landmarks;
  std::span<const HorizonSight> horizon;
  std::size_t size() const { return landmarks.size() + horizon.size(); }
};

// Standard deviation of where the picture shows it, its place's included.
double sigma_px(const LandmarkSight& sight, double focal_px);
// Seen minus modelled; empty: the model does not see it.
std::optional<glm::dvec2> residual_of(const PoseParameters& model, const ScaledLens& lens, const LandmarkSight& sight);
// Pixels by which a point is seen above the level line.
std::optional<double> residual_of(const PoseParameters& model, const ScaledLens& lens, const HorizonSight& sight);

// A turn of the camera about its own axes (radians); then in sigmas of the prior: ln scale, its place.
constexpr int kPoseUnknowns = 7;
using PoseCovariance = Eigen::Matrix<double, kPoseUnknowns, kPoseUnknowns>;

struct PoseFit {
  PoseParameters model;
  PoseCovariance covariance;
  // Of each sight, used or not: residual over sigma and its derivatives; one row for a point of the horizon, none for
  // what the model does not see at all.
  std::vector<Eigen::VectorXd> residuals;
  std::vector<Eigen::Matrix<double, Eigen::Dynamic, kPoseUnknowns>> slopes;
};

// `used`: one for each sight. Where no solution is found, `from` is kept.
PoseFit fit_pose(const PoseParameters& from, const ScaledLens& lens, const ScenePrior& prior, const PoseSights& sights,
                 const std::vector<bool>& used);

}  // namespace kasumi
