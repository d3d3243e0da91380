#include "calib/pose/pose_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include <ceres/ceres.h>
#include <ceres/rotation.h>
#include <Eigen/Dense>
#include <glm/geometric.hpp>

namespace kasumi {
namespace {

using PoseChange = std::array<double, kPoseUnknowns>;

PoseParameters changed(const PoseParameters& model, const double* change, const ScenePrior& prior) {
  return {model.to_world * rotation_by({change[0], change[1], change[2]}),
          model.log_scale + prior.scale_sigma * change[3],
          model.position_m + prior.position_sigma_m * glm::dvec3{change[4], change[5], change[6]}};
}

struct LandmarkCost {
  const ScaledLens* lens;
  const ScenePrior* prior;
  PoseParameters from;
  LandmarkSight sight;
  bool operator()(const double* change, double* residual) const {
    const auto off = residual_of(changed(from, change, *prior), *lens, sight);
    if (!off) return false;
    const double sigma = sigma_px(sight, lens->focal_px());
    residual[0] = off->x / sigma;
    residual[1] = off->y / sigma;
    return true;
  }
};

struct HorizonCost {
  const ScaledLens* lens;
  const ScenePrior* prior;
  PoseParameters from;
  HorizonSight sight;
  bool operator()(const double* change, double* residual) const {
    const auto off = residual_of(changed(from, change, *prior), *lens, sight);
    if (!off) return false;
    residual[0] = *off / sight.sigma_px;
    return true;
  }
};

// Also keeps parameters that are held fixed (sigma 0) at their start.
struct PosePriorCost {
  const ScenePrior* prior;
  PoseParameters from;
  bool operator()(const double* change, double* residual) const {
    const PoseParameters model = changed(from, change, *prior);
    residual[0] = model.to_world[0].z / prior->level_sigma.value;  // how far the picture's right side points up
    residual[1] = prior->scale_sigma > 0.0 ? model.log_scale / prior->scale_sigma : change[3];
    for (int i = 0; i < 3; ++i)
      residual[2 + i] = prior->position_sigma_m > 0.0 ? model.position_m[i] / prior->position_sigma_m : change[4 + i];
    return true;
  }
};

ceres::CostFunction* cost_of(const ScaledLens& lens, const ScenePrior& prior, const PoseParameters& from,
                             const PoseSights& sights, std::size_t i) {
  if (i < sights.landmarks.size())
    return new ceres::NumericDiffCostFunction<LandmarkCost, ceres::CENTRAL, 2, kPoseUnknowns>(
        new LandmarkCost{&lens, &prior, from, sights.landmarks[i]});
  return new ceres::NumericDiffCostFunction<HorizonCost, ceres::CENTRAL, 1, kPoseUnknowns>(
      new HorizonCost{&lens, &prior, from, sights.horizon[i - sights.landmarks.size()]});
}

void linearise(PoseFit& solved, const ScaledLens& lens, const ScenePrior& prior, const PoseSights& sights,
               const std::vector<bool>& used) {
  PoseChange none{};
  const double* at[] = {none.data()};
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, kPoseUnknowns, Eigen::RowMajor>;
  const auto evaluate = [&](const ceres::CostFunction& cost, Eigen::VectorXd& residual, Rows& rows) {
    residual.resize(cost.num_residuals());
    rows.resize(cost.num_residuals(), kPoseUnknowns);
    double* slopes[] = {rows.data()};
    return cost.Evaluate(at, residual.data(), slopes);
  };
  PoseCovariance information = PoseCovariance::Zero();
  Eigen::VectorXd residual;
  Rows rows;
  const ceres::NumericDiffCostFunction<PosePriorCost, ceres::CENTRAL, 5, kPoseUnknowns> known(
      new PosePriorCost{&prior, solved.model});
  if (evaluate(known, residual, rows)) information += rows.transpose() * rows;
  for (std::size_t i = 0; i < sights.size(); ++i) {
    const std::unique_ptr<ceres::CostFunction> cost(cost_of(lens, prior, solved.model, sights, i));
    const bool visible = evaluate(*cost, residual, rows);
    solved.residuals.push_back(visible ? residual : Eigen::VectorXd());
    solved.slopes.push_back(rows.topRows(visible ? rows.rows() : 0));
    if (visible && used[i]) information += rows.transpose() * rows;
  }
  solved.covariance = information.ldlt().solve(PoseCovariance::Identity());
}

}  // namespace

glm::dmat3 rotation_by(const glm::dvec3& axis_angle) {
  glm::dmat3 matrix;
  ceres::AngleAxisToRotationMatrix(&axis_angle[0], &matrix[0][0]);
  return matrix;
}

ScaledLens::ScaledLens(const LensDescription& description)
    : lens_(make_lens(description)), centre_(centre_of(description)), focal_px_(focal_px_of(description)) {}

std::optional<glm::dvec2> ScaledLens::project(const glm::dvec3& ray, double log_scale) const {
  const auto at = lens_->project(ray);
  if (!at) return std::nullopt;
  return centre_ + std::exp(log_scale) * (*at - centre_);
}

std::optional<glm::dvec3> ScaledLens::unproject(const glm::dvec2& pixel, double log_scale) const {
  return lens_->unproject(centre_ + std::exp(-log_scale) * (pixel - centre_));
}

double sigma_px(const LandmarkSight& sight, double focal_px) {
  return std::hypot(sight.sigma_px, focal_px * sight.place_sigma_m / std::max(1.0, glm::length(sight.place_m)));
}

std::optional<glm::dvec2> residual_of(const PoseParameters& model, const ScaledLens& lens, const LandmarkSight& sight) {
  const auto at = lens.project((sight.place_m - model.position_m) * model.to_world, model.log_scale);
  if (!at) return std::nullopt;
  return sight.pixel - *at;
}

std::optional<double> residual_of(const PoseParameters& model, const ScaledLens& lens, const HorizonSight& sight) {
  const auto ray = lens.unproject(sight.pixel, model.log_scale);
  if (!ray) return std::nullopt;
  const glm::dvec3 direction = model.to_world * *ray;
  const double elevation = std::atan2(direction.z, std::hypot(direction.x, direction.y));
  return lens.focal_px() * std::exp(model.log_scale) * (elevation + sight.dip.value);
}

PoseFit fit_pose(const PoseParameters& from, const ScaledLens& lens, const ScenePrior& prior, const PoseSights& sights,
                 const std::vector<bool>& used) {
  PoseChange change{};
  ceres::Problem problem;
  for (std::size_t i = 0; i < sights.size(); ++i)
    if (used[i]) problem.AddResidualBlock(cost_of(lens, prior, from, sights, i), nullptr, change.data());
  problem.AddResidualBlock(new ceres::NumericDiffCostFunction<PosePriorCost, ceres::CENTRAL, 5, kPoseUnknowns>(
                               new PosePriorCost{&prior, from}),
                           nullptr, change.data());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  options.function_tolerance = 1e-12;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  PoseFit solved{summary.IsSolutionUsable() ? changed(from, change.data(), prior) : from, {}, {}, {}};
  linearise(solved, lens, prior, sights, used);
  return solved;
}

}  // namespace kasumi
