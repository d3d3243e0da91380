#include "calib/scene_pose.hpp"

#include <algorithm>
#include <cmath>

#include <ceres/ceres.h>
#include <ceres/rotation.h>
#include <fmt/format.h>
#include <Eigen/Dense>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "base/earth.hpp"
#include "base/geometry.hpp"
#include "calib/calibration_file.hpp"

namespace kasumi {
namespace {

constexpr int kUnknowns = 7;
// A turn of the camera about its own axes (radians); then in sigmas of the prior: ln scale, its place.
using Change = std::array<double, kUnknowns>;
using Covariance = Eigen::Matrix<double, kUnknowns, kUnknowns>;

constexpr double kStartTolerance = 12.0;  // sigmas: a pair's pose is no better than the pair
// Of a squared studentised residual, by its degrees of freedom: exceeded once in a thousand.
constexpr double kContradicted1 = 10.8, kContradicted2 = 13.8;
constexpr double kUnchecked = 0.1;    // part of an error that shows in the landmark's own residual
constexpr double kSaysNothing = 0.7;  // of the prior's sigma still left

glm::dmat3 turn(const double* axis_angle) {
  glm::dmat3 matrix;
  ceres::AngleAxisToRotationMatrix(axis_angle, &matrix[0][0]);
  return matrix;
}

struct Model {
  glm::dmat3 to_world{1.0};
  double log_scale = 0.0;  // over the prior's lens
  glm::dvec3 position_m{0.0};

  Model changed(const double* change, const ScenePrior& prior) const {
    return {to_world * turn(change), log_scale + prior.scale_sigma * change[3],
            position_m + prior.position_sigma_m * glm::dvec3{change[4], change[5], change[6]}};
  }
};

// The prior's lens, scaled by a number that a fit moves.
class ScaledLens {
 public:
  explicit ScaledLens(const LensDescription& description)
      : lens_(make_lens(description)), centre_(centre_of(description)), focal_px_(focal_px_of(description)) {}

  std::optional<glm::dvec2> project(const glm::dvec3& ray, double log_scale) const {
    const auto at = lens_->project(ray);
    if (!at) return std::nullopt;
    return centre_ + std::exp(log_scale) * (*at - centre_);
  }
  std::optional<glm::dvec3> unproject(const glm::dvec2& pixel, double log_scale) const {
    return lens_->unproject(centre_ + std::exp(-log_scale) * (pixel - centre_));
  }
  double focal_px() const { return focal_px_; }

 private:
  LensPtr lens_;
  glm::dvec2 centre_;
  double focal_px_;
};

double sigma_px(const LandmarkSight& sight, double focal_px) {
  return std::hypot(sight.sigma_px, focal_px * sight.place_sigma_m / std::max(1.0, glm::length(sight.place_m)));
}

std::optional<glm::dvec2> residual_of(const Model& model, const ScaledLens& lens, const LandmarkSight& sight) {
  const auto at = lens.project((sight.place_m - model.position_m) * model.to_world, model.log_scale);
  if (!at) return std::nullopt;
  return sight.pixel - *at;
}

// Pixels by which a point is seen above the level line.
std::optional<double> residual_of(const Model& model, const ScaledLens& lens, const HorizonSight& sight) {
  const auto ray = lens.unproject(sight.pixel, model.log_scale);
  if (!ray) return std::nullopt;
  const glm::dvec3 direction = model.to_world * *ray;
  const double elevation = std::atan2(direction.z, std::hypot(direction.x, direction.y));
  return lens.focal_px() * std::exp(model.log_scale) * (elevation + sight.dip.value);
}

struct Sights {
  std::span<const LandmarkSight> landmarks;
  std::span<const HorizonSight> horizon;
  std::size_t size() const { return landmarks.size() + horizon.size(); }
};

struct LandmarkCost {
  const ScaledLens* lens;
  const ScenePrior* prior;
  Model from;
  LandmarkSight sight;
  bool operator()(const double* change, double* residual) const {
    const auto off = residual_of(from.changed(change, *prior), *lens, sight);
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
  Model from;
  HorizonSight sight;
  bool operator()(const double* change, double* residual) const {
    const auto off = residual_of(from.changed(change, *prior), *lens, sight);
    if (!off) return false;
    residual[0] = *off / sight.sigma_px;
    return true;
  }
};

// What is held (sigma 0) has no effect on anything else and is kept where it was by this.
struct PriorCost {
  const ScenePrior* prior;
  Model from;
  bool operator()(const double* change, double* residual) const {
    const Model model = from.changed(change, *prior);
    residual[0] = model.to_world[0].z / prior->level_sigma.value;  // how far the picture's right side points up
    residual[1] = prior->scale_sigma > 0.0 ? model.log_scale / prior->scale_sigma : change[3];
    for (int i = 0; i < 3; ++i)
      residual[2 + i] = prior->position_sigma_m > 0.0 ? model.position_m[i] / prior->position_sigma_m : change[4 + i];
    return true;
  }
};

struct Solved {
  Model model;
  Covariance covariance;
  // Of each sight, used or not: residual over sigma and its derivatives; one row for a point of the horizon.
  std::vector<Eigen::VectorXd> residuals;
  std::vector<Eigen::Matrix<double, Eigen::Dynamic, kUnknowns>> slopes;
};

ceres::CostFunction* cost_of(const ScaledLens& lens, const ScenePrior& prior, const Model& from, const Sights& sights,
                             std::size_t i) {
  if (i < sights.landmarks.size())
    return new ceres::NumericDiffCostFunction<LandmarkCost, ceres::CENTRAL, 2, kUnknowns>(
        new LandmarkCost{&lens, &prior, from, sights.landmarks[i]});
  return new ceres::NumericDiffCostFunction<HorizonCost, ceres::CENTRAL, 1, kUnknowns>(
      new HorizonCost{&lens, &prior, from, sights.horizon[i - sights.landmarks.size()]});
}

// Linearised at the solution. A sight that the model does not see at all has no rows.
void linearise(Solved& solved, const ScaledLens& lens, const ScenePrior& prior, const Sights& sights,
               const std::vector<bool>& used) {
  Change none{};
  const double* at[] = {none.data()};
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, kUnknowns, Eigen::RowMajor>;
  const auto evaluate = [&](const ceres::CostFunction& cost, Eigen::VectorXd& residual, Rows& rows) {
    residual.resize(cost.num_residuals());
    rows.resize(cost.num_residuals(), kUnknowns);
    double* slopes[] = {rows.data()};
    return cost.Evaluate(at, residual.data(), slopes);
  };
  Covariance information = Covariance::Zero();
  Eigen::VectorXd residual;
  Rows rows;
  const ceres::NumericDiffCostFunction<PriorCost, ceres::CENTRAL, 5, kUnknowns> known(
      new PriorCost{&prior, solved.model});
  if (evaluate(known, residual, rows)) information += rows.transpose() * rows;
  for (std::size_t i = 0; i < sights.size(); ++i) {
    const std::unique_ptr<ceres::CostFunction> cost(cost_of(lens, prior, solved.model, sights, i));
    const bool seen = evaluate(*cost, residual, rows);
    solved.residuals.push_back(seen ? residual : Eigen::VectorXd());
    solved.slopes.push_back(rows.topRows(seen ? rows.rows() : 0));
    if (seen && used[i]) information += rows.transpose() * rows;
  }
  solved.covariance = information.ldlt().solve(Covariance::Identity());
}

Solved solve(const Model& from, const ScaledLens& lens, const ScenePrior& prior, const Sights& sights,
             const std::vector<bool>& used) {
  Change change{};
  ceres::Problem problem;
  for (std::size_t i = 0; i < sights.size(); ++i)
    if (used[i]) problem.AddResidualBlock(cost_of(lens, prior, from, sights, i), nullptr, change.data());
  problem.AddResidualBlock(
      new ceres::NumericDiffCostFunction<PriorCost, ceres::CENTRAL, 5, kUnknowns>(new PriorCost{&prior, from}), nullptr,
      change.data());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  options.function_tolerance = 1e-12;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  Solved solved{summary.IsSolutionUsable() ? from.changed(change.data(), prior) : from, {}, {}, {}};
  linearise(solved, lens, prior, sights, used);
  return solved;
}

// The rotation that takes one pair of directions to another as well as a rotation can.
std::optional<glm::dmat3> rotation_between(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& to_a,
                                           const glm::dvec3& to_b) {
  const auto frame = [](const glm::dvec3& p, const glm::dvec3& q) -> std::optional<glm::dmat3> {
    const glm::dvec3 across = glm::cross(p, q);
    if (!(glm::length(across) > 1e-4)) return std::nullopt;
    const glm::dvec3 middle = glm::normalize(p + q), normal = glm::normalize(across);
    return glm::dmat3{middle, normal, glm::cross(middle, normal)};
  };
  const auto from = frame(a, b), to = frame(to_a, to_b);
  if (!from || !to) return std::nullopt;
  return *to * glm::transpose(*from);
}

// The scale at which two pixels see an angle, as near to the prior's as the prior allows: the angle falls as it grows.
double log_scale_of(const ScaledLens& lens, const glm::dvec2& a, const glm::dvec2& b, Radians apart, double sigma) {
  if (!(sigma > 0.0)) return 0.0;
  double low = -4.0 * sigma, high = 4.0 * sigma;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    const auto ray_a = lens.unproject(a, middle), ray_b = lens.unproject(b, middle);
    const bool wide = !ray_a || !ray_b || angle_between(*ray_a, *ray_b) > apart;
    (wide ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

struct Start {
  Model model;
  std::vector<bool> used;
};

std::optional<Start> best_pair(const Sights& sights, const ScaledLens& lens, const ScenePrior& prior) {
  std::optional<Start> best;
  double best_score = 0.0;
  const auto& all = sights.landmarks;
  for (std::size_t a = 0; a < all.size(); ++a)
    for (std::size_t b = a + 1; b < all.size(); ++b) {
      const glm::dvec3 to_a = glm::normalize(all[a].place_m), to_b = glm::normalize(all[b].place_m);
      Model model;
      model.log_scale = log_scale_of(lens, all[a].pixel, all[b].pixel, angle_between(to_a, to_b), prior.scale_sigma);
      const auto ray_a = lens.unproject(all[a].pixel, model.log_scale);
      const auto ray_b = lens.unproject(all[b].pixel, model.log_scale);
      const auto rotation = ray_a && ray_b ? rotation_between(*ray_a, *ray_b, to_a, to_b) : std::nullopt;
      if (!rotation) continue;
      model.to_world = *rotation;
      Start start{model, std::vector<bool>(sights.size(), true)};
      double score = 0.0;  // close ones count more
      for (std::size_t i = 0; i < all.size(); ++i) {
        const auto off = residual_of(model, lens, all[i]);
        // The camera's own place moves what is near.
        const double tolerance =
            kStartTolerance * std::hypot(sigma_px(all[i], lens.focal_px()),
                                         lens.focal_px() * prior.position_sigma_m / glm::length(all[i].place_m));
        const double closeness = off ? 1.0 - glm::dot(*off, *off) / (tolerance * tolerance) : -1.0;
        start.used[i] = closeness > 0.0;
        score += std::max(0.0, closeness);
      }
      if (score > best_score) {
        best_score = score;
        best = std::move(start);
      }
    }
  return best;
}

// One landmark and a level camera: the horizon says how level.
Start from_one(const Sights& sights, const ScaledLens& lens) {
  const auto& sight = sights.landmarks.front();
  const glm::dvec3 towards = glm::normalize(sight.place_m);
  Start start{{}, std::vector<bool>(sights.size(), true)};
  Radians heading = azimuth_angle(towards), pitch{};
  const auto ray = lens.unproject(sight.pixel, 0.0);
  constexpr int kRounds = 20;  // each leaves a small part of the error, for headings turn about another axis
  for (int i = 0; ray && i < kRounds; ++i) {
    start.model.to_world = camera_to_world(heading, pitch, {0.0});
    const glm::dvec3 seen = start.model.to_world * *ray;
    heading.value += std::remainder(azimuth_angle(towards).value - azimuth_angle(seen).value, 2.0 * kPi);
    pitch.value += zenith_angle(seen).value - zenith_angle(towards).value;
  }
  return start;
}

// chi^2 of the sights used, and what it would be on average with honest sigmas.
struct Misfit {
  double chi2 = 0.0, expected = 0.0;
};

Eigen::MatrixXd explained(const Solved& solved, std::size_t i) {
  return solved.slopes[i] * solved.covariance * solved.slopes[i].transpose();
}

Misfit misfit_of(const Solved& solved, const std::vector<bool>& used) {
  Misfit misfit;
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (!used[i]) continue;
    misfit.chi2 += solved.residuals[i].squaredNorm();
    misfit.expected += static_cast<double>(solved.residuals[i].size()) - explained(solved, i).trace();
  }
  return misfit;
}

// How far a sight contradicts the others, squared and in units of what is usual; directions in which nothing checks it
// left aside. `least_checked`: the part of an error that shows at all.
struct Contradiction {
  double squared = 0.0;
  double least_checked = 1.0;
};
Contradiction contradiction(const Solved& solved, std::size_t i, bool used) {
  const auto rows = solved.residuals[i].size();
  if (rows == 0) return {1e18, 1.0};
  const Eigen::MatrixXd own = Eigen::MatrixXd::Identity(rows, rows);
  const Eigen::MatrixXd variance = own + (used ? -1.0 : 1.0) * explained(solved, i);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(variance);
  Contradiction found{0.0, axes.eigenvalues().minCoeff()};
  for (int k = 0; k < rows; ++k) {
    const double along = axes.eigenvectors().col(k).dot(solved.residuals[i]);
    if (axes.eigenvalues()(k) > 0.01) found.squared += along * along / axes.eigenvalues()(k);
  }
  return found;
}

// Drops what the rest contradicts, the worst first, and takes in again what agrees after all.
Solved snoop(Model model, const ScaledLens& lens, const ScenePrior& prior, const Sights& sights,
             std::vector<bool>& used) {
  std::vector<bool> dropped(sights.size(), false);
  auto solved = solve(model, lens, prior, sights, used);
  for (std::size_t round = 0; round < 3 * sights.size(); ++round) {
    const auto misfit = misfit_of(solved, used);
    std::optional<std::size_t> worst, best;
    double most = 1.0, least = 1.0;
    for (std::size_t i = 0; i < sights.size(); ++i) {
      const double rows = i < sights.landmarks.size() ? 2.0 : 1.0;
      const double found = contradiction(solved, i, used[i]).squared;
      // The others' own scatter, should the sigmas have been too hopeful; two numbers say nothing of scatter.
      const double rest = misfit.expected - (used[i] ? rows : 0.0);
      const double scatter = rest >= 2.0 ? (misfit.chi2 - (used[i] ? found : 0.0)) / rest : 1.0;
      const double share = found / (std::max(1.0, scatter) * (rows == 2.0 ? kContradicted2 : kContradicted1));
      if (used[i] && share > most) {
        most = share;
        worst = i;
      }
      if (!used[i] && !dropped[i] && share < least) {
        least = share;
        best = i;
      }
    }
    if (!worst && !best) break;
    if (worst) {
      used[*worst] = false;
      dropped[*worst] = true;
    } else {
      used[*best] = true;
    }
    solved = solve(solved.model, lens, prior, sights, used);
  }
  return solved;
}

void fill_sigma(ScenePose& pose, const Solved& solved, const ScenePrior& prior, double inflation) {
  const Covariance covariance = inflation * solved.covariance;
  const auto angles_of = [](const glm::dmat3& to_world) {
    const auto a = heading_pitch_roll(to_world);
    return Eigen::Vector3d{a.heading.value, a.pitch.value, a.roll.value};
  };
  Eigen::Matrix3d by_turn;
  constexpr double kStep = 1e-6;
  for (int k = 0; k < 3; ++k) {
    std::array<double, 3> forward{}, back{};
    forward[static_cast<std::size_t>(k)] = kStep;
    back[static_cast<std::size_t>(k)] = -kStep;
    Eigen::Vector3d step =
        angles_of(pose.to_world * turn(forward.data())) - angles_of(pose.to_world * turn(back.data()));
    for (int i = 0; i < 3; ++i) step(i) = std::remainder(step(i), 2.0 * kPi);
    by_turn.col(k) = step / (2.0 * kStep);
  }
  const Eigen::Matrix3d angles = by_turn * covariance.topLeftCorner<3, 3>() * by_turn.transpose();
  const auto root = [](double variance) { return std::sqrt(std::max(0.0, variance)); };
  pose.sigma.heading = {root(angles(0, 0))};
  pose.sigma.pitch = {root(angles(1, 1))};
  pose.sigma.roll = {root(angles(2, 2))};
  pose.sigma.scale = prior.scale_sigma * root(covariance(3, 3));
  for (int i = 0; i < 3; ++i) pose.sigma.position_m[i] = prior.position_sigma_m * root(covariance(4 + i, 4 + i));

  // A ray r turns by w x r, and moves by its slope in ln scale.
  const ScaledLens lens(prior.lens);
  for (const double x : {0.0, 0.5, 1.0})
    for (const double y : {0.0, 0.5, 1.0}) {
      const glm::dvec2 pixel{x * (prior.width - 1.0), y * (prior.height - 1.0)};
      const auto ray = lens.unproject(pixel, solved.model.log_scale);
      const auto wider = lens.unproject(pixel, solved.model.log_scale + 1e-6);
      if (!ray || !wider) continue;
      const glm::dvec3 slope = prior.scale_sigma * (*wider - *ray) / 1e-6;
      Eigen::Matrix<double, 3, 4> by;
      by << 0.0, ray->z, -ray->y, slope.x, -ray->z, 0.0, ray->x, slope.y, ray->y, -ray->x, 0.0, slope.z;
      const Eigen::Matrix3d of_ray = by * covariance.topLeftCorner<4, 4>() * by.transpose();
      const double largest = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(of_ray).eigenvalues().maxCoeff();
      pose.sigma.anywhere = std::max(pose.sigma.anywhere, Radians{root(largest)});
    }
}

void tell_undetermined(ScenePose& pose, const Solved& solved, const Sights& sights, const std::vector<bool>& used,
                       const ScenePrior& prior) {
  auto& tell = pose.undetermined;
  if (pose.sigma.roll.value > kSaysNothing * prior.level_sigma.value)
    tell.push_back(fmt::format(
        "roll: the landmarks lie too close together to tell it, it is known to {:.2g} deg only, from the mounting",
        to_degrees(pose.sigma.roll)));
  if (prior.scale_sigma > 0.0 && pose.sigma.scale > kSaysNothing * prior.scale_sigma)
    tell.push_back(fmt::format("focal length: the landmarks say little of it, it is known to {:.2g} % only",
                               100.0 * pose.sigma.scale));
  for (std::size_t i = 0; i < sights.landmarks.size(); ++i)
    if (used[i] && contradiction(solved, i, true).least_checked < kUnchecked)
      tell.push_back(
          fmt::format("{}: too little else checks it; were it wrong, it would hardly show", sights.landmarks[i].name));
}

}  // namespace

Radians dip_of_horizon(double height_m, double refraction) {
  const double radius = kEarthRadius_m / (1.0 - refraction);
  return {std::acos(radius / (radius + std::max(0.0, height_m)))};
}

Result<ScenePose> pose_scene(std::span<const LandmarkSight> landmarks, std::span<const HorizonSight> horizon,
                             const ScenePrior& prior) {
  const bool one_will_do = landmarks.size() == 1 && horizon.size() >= 2;
  if (landmarks.size() < 2 && !one_will_do)
    return fail(FaultKind::bad_input,
                "{} landmarks: expected at least 2, and 4 to find a wrong one (or 1, and 2 points of the horizon)",
                landmarks.size());
  const Sights sights{landmarks, horizon};
  const ScaledLens lens(prior.lens);
  const auto start = one_will_do ? std::optional(from_one(sights, lens)) : best_pair(sights, lens, prior);
  if (!start)
    return fail(FaultKind::bad_input,
                "no two landmarks fit the picture: expected the right places, pixels, site and focal length");
  auto used = start->used;
  const auto solved = snoop(start->model, lens, prior, sights, used);

  ScenePose pose;
  pose.to_world = solved.model.to_world;
  pose.scale = std::exp(solved.model.log_scale);
  pose.lens = moved(prior.lens, centre_of(prior.lens), pose.scale);
  pose.position_m = solved.model.position_m;
  pose.used.assign(used.begin(), used.begin() + static_cast<std::ptrdiff_t>(landmarks.size()));
  pose.horizon_used.assign(used.begin() + static_cast<std::ptrdiff_t>(landmarks.size()), used.end());
  const auto agree = static_cast<std::size_t>(std::count(pose.used.begin(), pose.used.end(), true));
  if (2 * agree <= landmarks.size() || agree < std::min<std::size_t>(2, landmarks.size()))
    return fail(FaultKind::bad_input,
                "only {} of {} landmarks agree with each other: expected more than half of them, with the right "
                "places, pixels, site and focal length, and sigma_px and place_sigma_m as they are",
                agree, landmarks.size());
  double sum = 0.0;
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    pose.residuals_px.push_back(residual_of(solved.model, lens, landmarks[i]).value_or(glm::dvec2(1e4)));
    if (used[i]) sum += glm::dot(pose.residuals_px[i], pose.residuals_px[i]);
  }
  for (const auto& sight : horizon)
    pose.horizon_residuals_px.push_back(residual_of(solved.model, lens, sight).value_or(1e4));
  pose.rms_px = std::sqrt(sum / static_cast<double>(agree));
  const auto misfit = misfit_of(solved, used);
  pose.misfit = misfit.expected > 0.5 ? std::sqrt(misfit.chi2 / misfit.expected) : 1.0;
  fill_sigma(pose, solved, prior, misfit.expected >= 2.0 ? std::max(1.0, pose.misfit * pose.misfit) : 1.0);
  tell_undetermined(pose, solved, sights, used, prior);
  return pose;
}

}  // namespace kasumi
