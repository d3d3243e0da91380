#include "calib/lens/lens_fit.hpp"

#include <algorithm>
#include <cmath>

#include <ceres/ceres.h>
#include <ceres/rotation.h>
#include <glm/geometric.hpp>

#include "base/geometry.hpp"
#include "calib/lens/lens_projection.hpp"

namespace kasumi {
namespace {

constexpr double kHuber_px = 1.0;
using Pose = std::array<double, 6>;  // angle-axis, translation

template <class Projection>
struct CornerCost {
  glm::dvec2 pixel, on_board;

  template <class T>
  bool operator()(const T* lens, const T* pose, T* residual) const {
    const std::array at{T(on_board.x), T(on_board.y), T(0.0)};
    std::array<T, 3> ray;
    ceres::AngleAxisRotatePoint(pose, at.data(), ray.data());
    for (std::size_t i = 0; i < 3; ++i) ray[i] += pose[3 + i];
    std::array<T, 2> projected;
    if (!Projection::project(lens, ray.data(), projected.data())) return false;
    residual[0] = pixel.x - projected[0];
    residual[1] = pixel.y - projected[1];
    return true;
  }
};

Pose numbers_of(const BoardPose& pose) {
  Pose numbers{};
  ceres::RotationMatrixToAngleAxis(&pose.rotation[0][0], numbers.data());  // columns first, as glm has them
  for (int i = 0; i < 3; ++i) numbers[static_cast<std::size_t>(3 + i)] = pose.translation_m[i];
  return numbers;
}

BoardPose pose_of(const Pose& numbers) {
  BoardPose pose;
  ceres::AngleAxisToRotationMatrix(numbers.data(), &pose.rotation[0][0]);
  pose.translation_m = {numbers[3], numbers[4], numbers[5]};
  return pose;
}

ceres::Solver::Options solver_options() {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.max_num_iterations = 200;
  options.function_tolerance = 1e-10;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  return options;
}

// Corners outside the lens's reach get a residual of a whole picture.
ViewResiduals residuals(const Lens& lens, const BoardView& view, const BoardPose& pose) {
  constexpr double kUnseen_px = 1e4;
  ViewResiduals result{pose, {}, 0.0};
  double sum = 0.0;
  for (std::size_t i = 0; i < view.pixels.size(); ++i) {
    const auto projected = lens.project(pose.rotation * glm::dvec3(view.on_board[i], 0.0) + pose.translation_m);
    result.residuals_px.push_back(projected ? view.pixels[i] - *projected : glm::dvec2(kUnseen_px));
    sum += glm::dot(result.residuals_px.back(), result.residuals_px.back());
  }
  result.rms_px = std::sqrt(sum / static_cast<double>(view.pixels.size()));
  return result;
}

std::optional<BoardPose> first_pose(const Lens& lens, const BoardView& view) {
  std::vector<glm::dvec3> rays;
  std::vector<glm::dvec2> on_board;
  for (std::size_t i = 0; i < view.pixels.size(); ++i)
    if (const auto ray = lens.unproject(view.pixels[i])) {
      rays.push_back(*ray);
      on_board.push_back(view.on_board[i]);
    }
  return board_pose(rays, on_board);
}

template <class Projection>
using Parameters = std::array<double, Projection::kParameters>;

std::vector<double> first_parameters(LensFamily family, double focal_px, int width, int height) {
  const double x = 0.5 * (width - 1), y = 0.5 * (height - 1);
  switch (family) {
    case LensFamily::opencv_fisheye: return {focal_px, focal_px, x, y, 0.0, 0.0, 0.0, 0.0};
    // tan(theta) = s / (1 - s^2/3 - s^4/45): nearly equidistant
    case LensFamily::scaramuzza: return {focal_px, -1.0 / 3.0, 0.0, -1.0 / 45.0, x, y, 1.0, 0.0};
    case LensFamily::pinhole: return {focal_px, focal_px, x, y, 0.0, 0.0, 0.0, 0.0, 0.0};
  }
  return {};
}

LensDescription description_of(LensFamily family, const double* p, Radians largest_angle) {
  switch (family) {
    case LensFamily::opencv_fisheye:
      return {OpencvFisheyeParameters{{p[0], p[1]}, {p[2], p[3]}, {p[4], p[5], p[6], p[7]}}, largest_angle};
    case LensFamily::scaramuzza: {
      ScaramuzzaParameters model;
      const double f = p[0];
      model.polynomial = {-f, 0.0, -p[1] / f, -p[2] / (f * f), -p[3] / (f * f * f)};
      model.centre = {p[4], p[5]};
      model.c = p[6];
      model.d = p[7];
      return {model, largest_angle};
    }
    case LensFamily::pinhole:
      return {PinholeParameters{{p[0], p[1]}, {p[2], p[3]}, {p[4], p[5], p[6], p[7], p[8]}}, largest_angle};
  }
  return {};
}

// The inverse, for poses of views that were not fitted.
std::vector<double> parameters_of(const LensDescription& lens) {
  if (const auto* m = std::get_if<OpencvFisheyeParameters>(&lens.model))
    return {m->focal_px.x, m->focal_px.y, m->centre.x, m->centre.y, m->k[0], m->k[1], m->k[2], m->k[3]};
  if (const auto* m = std::get_if<ScaramuzzaParameters>(&lens.model)) {
    if (m->polynomial.size() != 5 || m->e != 0.0) return {};
    const double f = -m->polynomial[0];
    return {f,
            -m->polynomial[2] * f,
            -m->polynomial[3] * f * f,
            -m->polynomial[4] * f * f * f,
            m->centre.x,
            m->centre.y,
            m->c,
            m->d};
  }
  if (const auto* m = std::get_if<PinholeParameters>(&lens.model)) {
    const auto& k = m->distortion;
    return {m->focal_px.x, m->focal_px.y, m->centre.x, m->centre.y, k[0], k[1], k[2], k[3], k[4]};
  }
  return {};
}

struct Start {
  std::vector<double> lens;
  std::vector<BoardPose> poses;
};

// Focal lengths from the narrowest to the widest lens of the family; the one whose linear poses fit best begins.
std::optional<Start> best_start(LensFamily family, std::span<const BoardView> views, int width, int height) {
  const double half_diagonal = 0.5 * std::hypot(width, height);
  std::optional<Start> best;
  double least = 0.0;
  for (double corner_deg = 5.0; corner_deg <= 150.0; corner_deg *= 1.2) {
    const double angle = from_degrees(corner_deg).value;
    if (family == LensFamily::pinhole && corner_deg > 75.0) break;
    const double focal = half_diagonal / (family == LensFamily::pinhole ? std::tan(angle) : angle);
    Start start{first_parameters(family, focal, width, height), {}};
    const auto lens = make_lens(description_of(family, start.lens.data(), from_degrees(170.0)));
    double sum = 0.0;
    for (const auto& view : views) {
      const auto pose = first_pose(*lens, view);
      if (!pose) break;
      start.poses.push_back(*pose);
      const auto r = residuals(*lens, view, *pose);
      sum += std::min(r.rms_px, 1e4);
    }
    if (start.poses.size() != views.size()) continue;
    if (!best || sum < least) {
      least = sum;
      best = std::move(start);
    }
  }
  return best;
}

template <class Projection>
void add_view(ceres::Problem& problem, const BoardView& view, double* lens, double* pose, ceres::LossFunction* loss) {
  for (std::size_t i = 0; i < view.pixels.size(); ++i)
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<CornerCost<Projection>, 2, Projection::kParameters, 6>(
                                 new CornerCost<Projection>{view.pixels[i], view.on_board[i]}),
                             loss, lens, pose);
}

// Where in the parameters focal lengths and centre are.
constexpr std::array<int, 4> focal_and_centre(LensFamily family) {
  return family == LensFamily::scaramuzza ? std::array{0, 0, 4, 5} : std::array{0, 1, 2, 3};
}

std::optional<LensFit::Sigma> sigma_of(ceres::Problem& problem, double* lens, int size, LensFamily family,
                                       double residual_variance) {
  ceres::Covariance::Options options;
  options.num_threads = 1;
  ceres::Covariance covariance(options);
  std::vector<double> block(static_cast<std::size_t>(size * size));
  if (!covariance.Compute(std::vector<std::pair<const double*, const double*>>{{lens, lens}}, &problem) ||
      !covariance.GetCovarianceBlock(lens, lens, block.data()))
    return std::nullopt;
  const auto at = focal_and_centre(family);
  const auto sigma = [&](int i) {
    return std::sqrt(residual_variance * block[static_cast<std::size_t>(i * size + i)]);
  };
  return LensFit::Sigma{0.5 * (sigma(at[0]) + sigma(at[1])), {sigma(at[2]), sigma(at[3])}};
}

template <class Projection>
std::optional<LensFit> fit(LensFamily family, std::span<const BoardView> views, int width, int height) {
  auto start = best_start(family, views, width, height);
  if (!start) return std::nullopt;
  Parameters<Projection> lens{};
  std::copy(start->lens.begin(), start->lens.end(), lens.begin());
  std::vector<Pose> poses;
  for (const auto& pose : start->poses) poses.push_back(numbers_of(pose));

  ceres::HuberLoss huber(kHuber_px);
  ceres::Problem::Options ownership;
  ownership.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(ownership);
  for (std::size_t i = 0; i < views.size(); ++i)
    add_view<Projection>(problem, views[i], lens.data(), poses[i].data(), &huber);
  ceres::Solver::Summary summary;
  // First the poses and the focal lengths, so that distortion is not bent around a start that is far off.
  if constexpr (Projection::kParameters >= 8) {
    std::vector<int> held;
    const auto at = focal_and_centre(family);
    for (int i = 0; i < Projection::kParameters; ++i)
      if (i != at[0] && i != at[1] && !(family == LensFamily::scaramuzza && i == 6)) held.push_back(i);
    problem.SetManifold(lens.data(), new ceres::SubsetManifold(Projection::kParameters, held));
    ceres::Solve(solver_options(), &problem, &summary);
    problem.SetManifold(lens.data(), nullptr);
  }
  ceres::Solve(solver_options(), &problem, &summary);
  if (!summary.IsSolutionUsable()) return std::nullopt;
  const auto at = focal_and_centre(family);
  if (!(lens[static_cast<std::size_t>(at[0])] > 1.0 && lens[static_cast<std::size_t>(at[1])] > 1.0))
    return std::nullopt;

  // How far off the axis the corners lie is known once the poses are.
  double largest = 0.0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const auto pose = pose_of(poses[i]);
    for (const auto& corner : views[i].on_board)
      largest = std::max(largest,
                         angle_between({0, 0, 1}, pose.rotation * glm::dvec3(corner, 0.0) + pose.translation_m).value);
  }
  LensFit result;
  result.family = family;
  result.lens = description_of(family, lens.data(), Radians{largest});
  const auto fitted = make_lens(result.lens);
  double sum = 0.0;
  std::size_t corners = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    result.views.push_back(residuals(*fitted, views[i], pose_of(poses[i])));
    sum += result.views.back().rms_px * result.views.back().rms_px * static_cast<double>(views[i].pixels.size());
    corners += views[i].pixels.size();
  }
  result.rms_px = std::sqrt(sum / static_cast<double>(corners));
  const double freedoms =
      2.0 * static_cast<double>(corners) - Projection::kParameters - 6.0 * static_cast<double>(views.size());
  if (freedoms > 0.0) result.sigma = sigma_of(problem, lens.data(), Projection::kParameters, family, sum / freedoms);
  return result;
}

template <class Projection>
std::optional<ViewResiduals> refine_pose(const LensDescription& lens, std::vector<double> parameters,
                                         const BoardView& view) {
  const auto first = first_pose(*make_lens(lens), view);
  if (!first) return std::nullopt;
  Pose pose = numbers_of(*first);
  ceres::Problem problem;
  add_view<Projection>(problem, view, parameters.data(), pose.data(), nullptr);
  problem.SetParameterBlockConstant(parameters.data());
  auto options = solver_options();
  options.linear_solver_type = ceres::DENSE_QR;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable()) return std::nullopt;
  return residuals(*make_lens(lens), view, pose_of(pose));
}

}  // namespace

std::string_view name_of(LensFamily family) {
  switch (family) {
    case LensFamily::opencv_fisheye: return "opencv_fisheye";
    case LensFamily::scaramuzza: return "scaramuzza";
    case LensFamily::pinhole: return "pinhole";
  }
  return "";
}

std::optional<LensFit> fit_lens(LensFamily family, std::span<const BoardView> views, int width, int height) {
  if (views.empty()) return std::nullopt;
  switch (family) {
    case LensFamily::opencv_fisheye: return fit<FisheyeProjection>(family, views, width, height);
    case LensFamily::scaramuzza: return fit<ScaramuzzaProjection>(family, views, width, height);
    case LensFamily::pinhole: return fit<PinholeProjection>(family, views, width, height);
  }
  return std::nullopt;
}

std::optional<ViewResiduals> residuals_of(const LensDescription& lens, const BoardView& view) {
  auto wide = lens;
  wide.largest_angle = from_degrees(170.0);  // the model is asked beyond the corners it was fitted to
  auto parameters = parameters_of(lens);
  if (parameters.empty()) return std::nullopt;
  if (std::holds_alternative<OpencvFisheyeParameters>(lens.model))
    return refine_pose<FisheyeProjection>(wide, std::move(parameters), view);
  if (std::holds_alternative<ScaramuzzaParameters>(lens.model))
    return refine_pose<ScaramuzzaProjection>(wide, std::move(parameters), view);
  return refine_pose<PinholeProjection>(wide, std::move(parameters), view);
}

}  // namespace kasumi
