#include "calib/pose/orientation_fit.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include <ceres/ceres.h>
#include <ceres/rotation.h>
#include <fmt/format.h>
#include <Eigen/Dense>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "base/statistics.hpp"
#include "calib/pose/rotation.hpp"

namespace kasumi {
namespace {

constexpr Radians kSamePlace = from_degrees(3.0);
constexpr int kTrials = 500;
constexpr double kInlier_px = 4.0, kInlierSigmas = 4.0;  // the first with a lens not yet fitted
constexpr double kFewSights_px = 0.5;
constexpr double kUndeterminedOrientation = 0.7;  // of the prior's sigma still left

// A turn of the world (axis times angle, radians), the centre's shift in pixels, ln scale, the two odd terms, the sag.
constexpr int kChanges = 9;
using OrientationChange = std::array<double, kChanges>;
using OrientationMatrix = Eigen::Matrix<double, kChanges, kChanges>;
constexpr double kHeld = 1e-9;      // standard deviation of what is not fitted
constexpr double kStepDown = 0.01;  // [rad]

glm::dmat3 turn(const double* axis_angle) {
  glm::dmat3 matrix;
  ceres::AngleAxisToRotationMatrix(axis_angle, &matrix[0][0]);
  return matrix;
}

// Where a sun seems to be.
Direction lowered(const Direction& sun, double by) {
  if (by == 0.0) return sun;
  const double sine = std::hypot(sun.x, sun.y);
  if (sine < 1e-9) return sun;
  const glm::dvec3 down{sun.x * sun.z / sine, sun.y * sun.z / sine, -sine};
  return std::cos(by) * sun + std::sin(by) * down;
}

// A residual in units of what a sight may be off by, along the vertical and across it.
glm::dvec2 in_sigmas(const glm::dvec2& residual, const SunSight& sight, const std::optional<glm::dvec2>& down) {
  if (sight.across == 1.0 || !down || glm::length(*down) < 1e-9) return residual / sight.relative_sigma;
  const glm::dvec2 along = glm::normalize(*down);
  return glm::dvec2{glm::dot(residual, along), glm::dot(residual, {-along.y, along.x}) / sight.across} /
         sight.relative_sigma;
}

struct Model {
  glm::dmat3 to_world;
  LensDescription lens;
  double sag = 0.0;

  Model changed(const double* change) const {
    Model made{turn(change) * to_world,
               moved(lens, centre_of(lens) + glm::dvec2{change[3], change[4]}, std::exp(change[5])), sag + change[8]};
    if (auto* fisheye = std::get_if<OpencvFisheyeParameters>(&made.lens.model)) {
      fisheye->k[0] += change[6];
      fisheye->k[1] += change[7];
    }
    return made;
  }
};

// The lens beyond its own end too, where a fit may look in passing.
LensDescription wide(LensDescription lens) {
  lens.largest_angle = from_degrees(150.0);
  return lens;
}

struct SightCost {
  Model from;  // wide
  LensPtr lens;
  SunSight sight;
  double sigma_px;

  bool operator()(const double* change, double* residual) const {
    // Only the odd terms need another lens; a shift and a scale are made in the picture.
    const bool other = change[6] != 0.0 || change[7] != 0.0;
    const double odd[kChanges]{0.0, 0.0, 0.0, 0.0, 0.0, 0.0, change[6], change[7], 0.0};
    const auto asked = other ? make_lens(from.changed(odd).lens) : lens;
    const glm::dmat3 to_world = turn(change) * from.to_world;
    const double by = (from.sag + change[8]) * sight.lowered;
    const auto at = asked->project(lowered(sight.sun, by) * to_world);
    if (!at) return false;
    std::optional<glm::dvec2> down;
    if (sight.across != 1.0)
      if (const auto below = asked->project(lowered(sight.sun, by + kStepDown) * to_world)) down = *below - *at;
    const glm::dvec2 centre = centre_of(from.lens);
    const glm::dvec2 seen = centre + glm::dvec2{change[3], change[4]} + std::exp(change[5]) * (*at - centre);
    const glm::dvec2 off = in_sigmas(sight.pixel - seen, sight, down) / sigma_px;
    residual[0] = off.x;
    residual[1] = off.y;
    return true;
  }
};

std::array<double, 2> odd_of(const LensDescription& lens) {
  const auto* fisheye = std::get_if<OpencvFisheyeParameters>(&lens.model);
  return fisheye ? std::array{fisheye->k[0], fisheye->k[1]} : std::array<double, 2>{};
}

// How far the optical axis is from where it was mounted, the centre and the scale from what was known of them.
struct OrientationPriorCost {
  OrientationPrior prior;
  Model model;

  bool operator()(const double* change, double* residual) const {
    const glm::dvec3 axis = turn(change) * model.to_world[2];
    // Heights of the axes above the horizon do not turn with the azimuth.
    const glm::dvec3 mounted = prior.to_world[2];
    const double off = std::acos(std::clamp(mounted.z, -1.0, 1.0));
    if (off < 1e-6) {
      residual[0] = axis.x / prior.level_sigma.value;
      residual[1] = axis.y / prior.level_sigma.value;
    } else {
      residual[0] = (std::atan2(std::hypot(axis.x, axis.y), axis.z) - off) / prior.level_sigma.value;
      residual[1] = 0.0;
    }
    const auto from = centre_of(prior.lens);
    const glm::dvec2 centre = centre_of(model.lens) + glm::dvec2{change[3], change[4]};
    residual[2] = (centre.x - from.x) / prior.centre_sigma_px.x;
    residual[3] = (centre.y - from.y) / prior.centre_sigma_px.y;
    const double scale = std::log(focal_px_of(model.lens) / focal_px_of(prior.lens)) + change[5];
    residual[4] = scale / prior.scale_sigma;
    const auto odd = odd_of(model.lens), before = odd_of(prior.lens);
    for (std::size_t k = 0; k < odd.size(); ++k)
      residual[5 + k] =
          prior.odd_sigma[k] > 0.0 ? (odd[k] + change[6 + k] - before[k]) / prior.odd_sigma[k] : change[6 + k] / kHeld;
    residual[7] = prior.sag_sigma.value > 0.0 ? (model.sag + change[8]) / prior.sag_sigma.value : change[8] / kHeld;
    return true;
  }
};

struct Residuals {
  std::vector<glm::dvec2> px, relative;  // seen minus modelled; in units of relative_sigma and across
};

Residuals residuals_of(const Model& model, std::span<const SunSight> sights) {
  const auto lens = make_lens(wide(model.lens));
  Residuals residuals;
  for (const auto& sight : sights) {
    const double by = model.sag * sight.lowered;
    const auto at = lens->project(lowered(sight.sun, by) * model.to_world);
    const auto below = lens->project(lowered(sight.sun, by + kStepDown) * model.to_world);
    residuals.px.push_back(at ? sight.pixel - *at : glm::dvec2(1e4));
    residuals.relative.push_back(
        in_sigmas(residuals.px.back(), sight, at && below ? std::optional(*below - *at) : std::nullopt));
  }
  return residuals;
}

std::vector<bool> agreeing(const Model& model, std::span<const SunSight> sights, double tolerance_px) {
  std::vector<bool> agree;
  for (const auto& off : residuals_of(model, sights).relative) agree.push_back(glm::length(off) <= tolerance_px);
  return agree;
}

// The two sights that explain most of the others under the prior lens. A scale error of a few percent distorts all
// rotations, so the tolerance grows with the lens's uncertainty.
std::optional<Model> consensus(std::span<const SunSight> sights, const OrientationPrior& prior) {
  const auto lens = make_lens(wide(prior.lens));
  const double tolerance_px =
      kInlier_px + glm::length(prior.centre_sigma_px) + prior.scale_sigma * focal_px_of(prior.lens);
  std::mt19937_64 random(1);
  std::optional<Model> best;
  double best_score = 0.0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const auto& a = sights[random() % sights.size()];
    const auto& b = sights[random() % sights.size()];
    const auto ray_a = lens->unproject(a.pixel), ray_b = lens->unproject(b.pixel);
    if (!ray_a || !ray_b) continue;
    const auto rotation = rotation_between(*ray_a, *ray_b, a.sun, b.sun, 0.02);
    if (!rotation) continue;
    const Model model{*rotation, prior.lens, 0.0};
    double score = 0.0;  // close ones count more
    for (const auto& residual : residuals_of(model, sights).px)
      score += std::max(0.0, 1.0 - glm::dot(residual, residual) / (tolerance_px * tolerance_px));
    if (score > best_score) {
      best_score = score;
      best = model;
    }
  }
  // Two sights always agree with themselves.
  if (!best || (sights.size() > 2 && best_score < 2.2)) return std::nullopt;
  return best;
}

struct Solved {
  Model model;
  OrientationMatrix covariance;
};

Solved solve(const Model& from, std::span<const SunSight> sights, const std::vector<bool>& used,
             const OrientationPrior& prior, double sigma_px) {
  const Model start{from.to_world, wide(from.lens), from.sag};
  const auto lens = make_lens(start.lens);
  OrientationChange change{};
  ceres::Problem problem;
  for (std::size_t i = 0; i < sights.size(); ++i)
    if (used[i])
      problem.AddResidualBlock(new ceres::NumericDiffCostFunction<SightCost, ceres::CENTRAL, 2, kChanges>(
                                   new SightCost{start, lens, sights[i], sigma_px}),
                               new ceres::CauchyLoss(2.0), change.data());
  problem.AddResidualBlock(new ceres::NumericDiffCostFunction<OrientationPriorCost, ceres::CENTRAL, 8, kChanges>(
                               new OrientationPriorCost{prior, from}),
                           nullptr, change.data());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  options.function_tolerance = 1e-12;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);

  Solved solved{from.changed(change.data()), {}};
  ceres::Problem::EvaluateOptions evaluation;
  evaluation.apply_loss_function = false;
  ceres::CRSMatrix jacobian;
  problem.Evaluate(evaluation, nullptr, nullptr, nullptr, &jacobian);
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(jacobian.num_rows, jacobian.num_cols);
  for (int row = 0; row < jacobian.num_rows; ++row)
    for (int k = jacobian.rows[static_cast<std::size_t>(row)]; k < jacobian.rows[static_cast<std::size_t>(row) + 1];
         ++k)
      dense(row, jacobian.cols[static_cast<std::size_t>(k)]) = jacobian.values[static_cast<std::size_t>(k)];
  solved.covariance = (dense.transpose() * dense).ldlt().solve(OrientationMatrix::Identity());
  return solved;
}

// Robust standard deviation of one coordinate.
double spread_px(const Model& model, std::span<const SunSight> sights, const std::vector<bool>& used) {
  const auto residuals = residuals_of(model, sights).relative;
  std::vector<double> all;
  for (std::size_t i = 0; i < residuals.size(); ++i)
    if (used[i]) {
      all.push_back(residuals[i].x);
      all.push_back(residuals[i].y);
    }
  return robust_sigma(std::move(all));
}

bool at_one_place(std::span<const SunSight> sights) {
  return std::all_of(sights.begin(), sights.end(),
                     [&](const SunSight& s) { return angle_between(s.sun, sights[0].sun) <= kSamePlace; });
}

void finish(OrientationFit& result, std::span<const SunSight> sights) {
  auto residuals = residuals_of({result.to_world, result.lens, result.sag.value}, sights);
  result.residuals_px = std::move(residuals.px);
  for (const glm::dvec2& off : residuals.relative) result.misfits_px.push_back(glm::length(off));
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < sights.size(); ++i)
    if (result.used[i]) {
      sum += glm::dot(result.residuals_px[i], result.residuals_px[i]);
      ++count;
    }
  result.rms_px = count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0.0;
}

// The azimuth alone: the mounted camera turned about the vertical until the sun's azimuths agree.
Result<OrientationFit> azimuth_only(std::span<const SunSight> sights, const OrientationPrior& prior) {
  const auto lens = make_lens(wide(prior.lens));
  glm::dvec2 towards{0.0};
  double cotangent = 0.0;
  OrientationFit result;
  for (const auto& sight : sights) {
    const auto ray = lens->unproject(sight.pixel);
    result.used.push_back(ray.has_value());
    if (!ray) continue;
    const double by = azimuth_angle(sight.sun).value - azimuth_angle(prior.to_world * *ray).value;
    towards += glm::dvec2{std::cos(by), std::sin(by)};
    const double zenith = std::max(zenith_angle(sight.sun).value, 1e-3);
    cotangent = std::max(cotangent, 1.0 / std::tan(zenith));
  }
  if (!(glm::length(towards) > 0.0))
    return fail(FaultKind::bad_input, "the sun's place in the picture is outside of what the lens sees");
  const double by = std::atan2(towards.y, towards.x);
  const std::array vertical{0.0, 0.0, -by};  // azimuth runs clockwise
  result.to_world = turn(vertical.data()) * prior.to_world;
  result.lens = prior.lens;
  const double zenith = zenith_angle(sights[0].sun).value;
  const double across = glm::length(prior.centre_sigma_px) / std::sqrt(2.0) / focal_px_of(prior.lens);
  result.sigma.azimuth = {std::hypot(prior.level_sigma.value * cotangent, across / std::max(std::sin(zenith), 1e-3))};
  result.sigma.tilt_east = result.sigma.tilt_north = prior.level_sigma;
  result.sigma.centre_px = prior.centre_sigma_px;
  result.sigma.scale = prior.scale_sigma;
  result.undetermined = {
      "the sun was seen at one place, which fixes the azimuth only; tilt, centre and focal length are as they were"};
  finish(result, sights);
  return result;
}

void add_undetermined(OrientationFit& result, const OrientationPrior& prior) {
  const auto& sigma = result.sigma;
  const auto add_if = [&](bool open, const char* what, double value, const char* unit) {
    if (open)
      result.undetermined.push_back(
          fmt::format("{}: hardly determined by the sun's path; it is known only to {:.2g} {}", what, value, unit));
  };
  const double level = prior.level_sigma.value;
  add_if(sigma.tilt_east.value > kUndeterminedOrientation * level, "tilt to the east", to_degrees(sigma.tilt_east),
         "deg");
  add_if(sigma.tilt_north.value > kUndeterminedOrientation * level, "tilt to the north", to_degrees(sigma.tilt_north),
         "deg");
  add_if(std::max(sigma.centre_px.x / prior.centre_sigma_px.x, sigma.centre_px.y / prior.centre_sigma_px.y) >
             kUndeterminedOrientation,
         "centre of the lens", std::max(sigma.centre_px.x, sigma.centre_px.y), "px");
  add_if(sigma.scale > kUndeterminedOrientation * prior.scale_sigma, "focal length", 100.0 * sigma.scale, "percent");
}

}  // namespace

Result<OrientationFit> fit_orientation(std::span<const SunSight> sights, const OrientationPrior& prior) {
  if (sights.empty())
    return fail(FaultKind::bad_input, "the sun was seen in no picture: expected at least one with the sun's disc");
  if (at_one_place(sights)) return azimuth_only(sights, prior);
  const auto start = consensus(sights, prior);
  if (!start)
    return fail(FaultKind::bad_input,
                "the sun's places in the {} pictures do not agree with its way across the sky: expected the right "
                "time, site and lens",
                sights.size());

  // First what a lens not yet fitted can explain; then, as lens and noise become known, what is within 4 sigma.
  Model model = *start;
  const double generous =
      kInlier_px + 2.0 * (glm::length(prior.centre_sigma_px) + prior.scale_sigma * focal_px_of(prior.lens));
  auto used = agreeing(model, sights, generous);
  double sigma_px = 1.0;
  Solved solved{model, {}};
  for (int round = 0; round < 6; ++round) {
    solved = solve(model, sights, used, prior, sigma_px);
    model = solved.model;
    // A few sights agree by chance, since so much is free to follow them.
    const bool few = std::count(used.begin(), used.end(), true) < 10;
    sigma_px = std::max(few ? kFewSights_px : prior.least_sigma_px, spread_px(model, sights, used));
    auto next = agreeing(model, sights, kInlierSigmas * sigma_px);
    if (std::count(next.begin(), next.end(), true) < 2) break;
    if (round >= 2 && next == used) break;
    used = std::move(next);
  }
  solved = solve(model, sights, used, prior, sigma_px);

  OrientationFit result;
  result.to_world = solved.model.to_world;
  result.lens = solved.model.lens;
  result.lens.largest_angle = prior.lens.largest_angle;
  result.scale = focal_px_of(result.lens) / focal_px_of(prior.lens);
  result.sag = Radians{solved.model.sag};
  result.used = used;
  const auto sigma = [&](int i) { return std::sqrt(std::max(0.0, solved.covariance(i, i))); };
  // A turn about the north axis tilts the optical axis to the east, about the east axis to the south.
  result.sigma = {{sigma(2)}, {sigma(1)}, {sigma(0)}, {sigma(3), sigma(4)}, sigma(5), {sigma(6), sigma(7)}};
  finish(result, sights);
  add_undetermined(result, prior);
  return result;
}

}  // namespace kasumi
