#include "calib/pose/scene_pose.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <Eigen/Dense>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "base/earth.hpp"
#include "base/geometry.hpp"
#include "calib/calibration_file.hpp"
#include "calib/pose/pose_screening.hpp"
#include "calib/pose/rotation.hpp"

namespace kasumi {
namespace {

constexpr double kStartTolerance = 12.0;   // sigmas: a pair's pose is no better than the pair
constexpr double kUnchecked = 0.1;         // part of an error that shows in the landmark's own residual
constexpr double kUndeterminedPose = 0.7;  // of the prior's sigma still left

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
  PoseParameters model;
  std::vector<bool> used;
};

std::optional<Start> best_pair(const PoseSights& sights, const ScaledLens& lens, const ScenePrior& prior) {
  std::optional<Start> best;
  double best_score = 0.0;
  const auto& all = sights.landmarks;
  for (std::size_t a = 0; a < all.size(); ++a)
    for (std::size_t b = a + 1; b < all.size(); ++b) {
      const glm::dvec3 to_a = glm::normalize(all[a].place_m), to_b = glm::normalize(all[b].place_m);
      PoseParameters model;
      model.log_scale = log_scale_of(lens, all[a].pixel, all[b].pixel, angle_between(to_a, to_b), prior.scale_sigma);
      const auto ray_a = lens.unproject(all[a].pixel, model.log_scale);
      const auto ray_b = lens.unproject(all[b].pixel, model.log_scale);
      const auto rotation = ray_a && ray_b ? rotation_between(*ray_a, *ray_b, to_a, to_b, 1e-4) : std::nullopt;
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
Start from_one(const PoseSights& sights, const ScaledLens& lens) {
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

void fill_sigma(ScenePose& pose, const PoseFit& solved, const ScenePrior& prior, double inflation) {
  const PoseCovariance covariance = inflation * solved.covariance;
  const auto angles_of = [](const glm::dmat3& to_world) {
    const auto a = heading_pitch_roll(to_world);
    return Eigen::Vector3d{a.heading.value, a.pitch.value, a.roll.value};
  };
  Eigen::Matrix3d by_turn;
  constexpr double kStep = 1e-6;
  for (int k = 0; k < 3; ++k) {
    glm::dvec3 forward{0.0}, back{0.0};
    forward[k] = kStep;
    back[k] = -kStep;
    Eigen::Vector3d step =
        angles_of(pose.to_world * rotation_by(forward)) - angles_of(pose.to_world * rotation_by(back));
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

void add_undetermined(ScenePose& pose, const PoseFit& solved, const PoseSights& sights, const std::vector<bool>& used,
                      const ScenePrior& prior) {
  auto& undetermined = pose.undetermined;
  if (pose.sigma.roll.value > kUndeterminedPose * prior.level_sigma.value)
    undetermined.push_back(
        fmt::format("roll: the landmarks lie too close together; it is known only to {:.2g} deg, from the mounting",
                    to_degrees(pose.sigma.roll)));
  if (prior.scale_sigma > 0.0 && pose.sigma.scale > kUndeterminedPose * prior.scale_sigma)
    undetermined.push_back(fmt::format("focal length: hardly determined by the landmarks; it is known only to {:.2g} %",
                                       100.0 * pose.sigma.scale));
  for (std::size_t i = 0; i < sights.landmarks.size(); ++i)
    if (used[i] && contradiction(solved, i, true).least_checked < kUnchecked)
      undetermined.push_back(
          fmt::format("{}: too little else checks it; an error would hardly show", sights.landmarks[i].name));
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
  const PoseSights sights{landmarks, horizon};
  const ScaledLens lens(prior.lens);
  const auto start = one_will_do ? std::optional(from_one(sights, lens)) : best_pair(sights, lens, prior);
  if (!start)
    return fail(FaultKind::bad_input,
                "no two landmarks fit the picture: expected the right places, pixels, site and focal length");
  auto used = start->used;
  const auto solved = fit_without_wrong(start->model, lens, prior, sights, used);

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
  add_undetermined(pose, solved, sights, used, prior);
  return pose;
}

}  // namespace kasumi
