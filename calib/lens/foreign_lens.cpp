#include "calib/lens/foreign_lens.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Dense>
#include <glm/geometric.hpp>

namespace kasumi {
namespace {

constexpr int kAngles = 120, kTurns = 16;
constexpr int kHighestPower = 14;

// Directions all over the lens that fall into the picture.
struct SeenDirection {
  glm::dvec3 ray;
  double angle;
  glm::dvec2 pixel;
};

std::vector<SeenDirection> seen_directions(const ForeignLens& lens, double largest_angle) {
  std::vector<SeenDirection> seen;
  for (int j = 0; j < kTurns; ++j)
    for (int i = 0; i <= kAngles; ++i) {
      const double angle = largest_angle * i / kAngles, turn = 2.0 * kPi * j / kTurns;
      const glm::dvec3 ray{std::sin(angle) * std::cos(turn), std::sin(angle) * std::sin(turn), std::cos(angle)};
      const auto pixel = lens.project(ray);
      if (!pixel) break;  // beyond, the model has turned back
      const bool inside =
          pixel->x >= -0.5 && pixel->y >= -0.5 && pixel->x <= lens.width - 0.5 && pixel->y <= lens.height - 0.5;
      if (inside) seen.push_back({ray, angle, *pixel});
    }
  return seen;
}

double most_moved_px(const LensDescription& lens, const std::vector<SeenDirection>& seen) {
  const auto made = make_lens(lens);
  double most = 0.0;
  for (const auto& direction : seen) {
    const auto pixel = made->project(direction.ray);
    if (!pixel) return std::numeric_limits<double>::infinity();
    most = std::max(most, glm::distance(*pixel, direction.pixel));
  }
  return most;
}

// u = x (1 + k1 r2 + ...) + ..., which is linear in the coefficients; focal lengths and centre are given.
std::optional<LensDescription> fitted_pinhole(const std::vector<SeenDirection>& seen, const glm::dvec2& focal,
                                              const glm::dvec2& centre) {
  std::vector<const SeenDirection*> ahead;
  for (const auto& direction : seen)
    if (direction.ray.z > 0.05) ahead.push_back(&direction);
  if (ahead.size() < 20 || ahead.size() != seen.size()) return std::nullopt;
  Eigen::MatrixXd equations(2 * static_cast<Eigen::Index>(ahead.size()), 5);
  Eigen::VectorXd wanted(equations.rows());
  for (std::size_t i = 0; i < ahead.size(); ++i) {
    const double x = ahead[i]->ray.x / ahead[i]->ray.z, y = ahead[i]->ray.y / ahead[i]->ray.z, r2 = x * x + y * y;
    const auto row = 2 * static_cast<Eigen::Index>(i);
    const glm::dvec2 to = (ahead[i]->pixel - centre) / focal;
    equations.row(row) << x * r2, x * r2 * r2, 2.0 * x * y, r2 + 2.0 * x * x, x * r2 * r2 * r2;
    equations.row(row + 1) << y * r2, y * r2 * r2, r2 + 2.0 * y * y, 2.0 * x * y, y * r2 * r2 * r2;
    wanted(row) = to.x - x;
    wanted(row + 1) = to.y - y;
  }
  const Eigen::VectorXd k = equations.colPivHouseholderQr().solve(wanted);
  if (!k.allFinite()) return std::nullopt;
  return LensDescription{PinholeParameters{focal, centre, {k(0), k(1), k(2), k(3), k(4)}}};
}

// Scaramuzza's polynomial is linear in its coefficients: forward(rho) = rho / tan(theta).
std::optional<LensDescription> fitted_polynomial(const std::vector<SeenDirection>& seen, const SensorMatrix& matrix,
                                                 int power, double largest_angle) {
  ScaramuzzaParameters model;
  model.centre = {matrix.cx, matrix.cy};
  model.e = matrix.skew / matrix.fx;
  model.c = matrix.fy / matrix.fx;
  const double unit = matrix.fx;
  Eigen::MatrixXd equations(static_cast<Eigen::Index>(seen.size()), power);
  Eigen::VectorXd wanted(equations.rows());
  Eigen::Index row = 0;
  for (const auto& direction : seen) {
    if (direction.angle < 1e-3) continue;
    const glm::dvec2 off = direction.pixel - model.centre;
    const double v = off.y / model.c, rho = std::hypot(off.x - model.e * v, v) / unit;
    // Weighted, so that a step of the equation is one of the angle.
    const double weight = std::sin(direction.angle) / std::max(rho, 1e-9);
    double term = 1.0;
    for (int i = 0; i < power; ++i) {
      equations(row, i) = weight * term;
      term *= i == 0 ? rho * rho : rho;  // no linear term: the model's own form
    }
    wanted(row++) = std::cos(direction.angle);
  }
  if (row < 4 * power) return std::nullopt;
  const Eigen::VectorXd a = equations.topRows(row).colPivHouseholderQr().solve(wanted.head(row));
  if (!a.allFinite() || !(a(0) > 0.0)) return std::nullopt;
  model.polynomial.assign(static_cast<std::size_t>(power) + 1, 0.0);
  for (int i = 0; i < power; ++i) {
    const int exponent = i == 0 ? 0 : i + 1;
    model.polynomial[static_cast<std::size_t>(exponent)] = -a(i) * std::pow(unit, 1.0 - exponent);
  }
  if (!(model.c > 0.0)) return std::nullopt;
  return LensDescription{std::move(model), Radians{largest_angle}};
}

std::optional<SensorMatrix> matrix_on_axis(const ForeignLens& lens) {
  constexpr double kSmall = 1e-5;
  const auto at = [&](double x, double y) { return lens.project(glm::normalize(glm::dvec3{x, y, 1.0})); };
  const auto centre = at(0.0, 0.0), left = at(-kSmall, 0.0), right = at(kSmall, 0.0), up = at(0.0, -kSmall),
             down = at(0.0, kSmall);
  if (!centre || !left || !right || !up || !down) return std::nullopt;
  const auto across = (*right - *left) / (2.0 * kSmall), along = (*down - *up) / (2.0 * kSmall);
  return SensorMatrix{across.x, along.y, centre->x, centre->y, along.x};
}

}  // namespace

glm::dvec2 brown_distorted(const glm::dvec2& p, const BrownCoefficients& k) {
  const double x = p.x, y = p.y, r2 = x * x + y * y, r4 = r2 * r2, r6 = r4 * r2;
  const double radial = (1.0 + k[0] * r2 + k[1] * r4 + k[4] * r6) / (1.0 + k[5] * r2 + k[6] * r4 + k[7] * r6);
  return {x * radial + 2.0 * k[2] * x * y + k[3] * (r2 + 2.0 * x * x) + k[8] * r2 + k[9] * r4,
          y * radial + k[2] * (r2 + 2.0 * y * y) + 2.0 * k[3] * x * y + k[10] * r2 + k[11] * r4};
}

void set_pinhole(ForeignLens& lens, const SensorMatrix& matrix, const BrownCoefficients& k) {
  lens.project = [matrix, k](const glm::dvec3& ray) -> std::optional<glm::dvec2> {
    if (!(ray.z > 1e-9)) return std::nullopt;
    return matrix(brown_distorted({ray.x / ray.z, ray.y / ray.z}, k));
  };
  const bool plain = matrix.skew == 0.0 && std::all_of(k.begin() + 5, k.end(), [](double x) { return x == 0.0; });
  if (plain)
    lens.exact = LensDescription{
        PinholeParameters{{matrix.fx, matrix.fy}, {matrix.cx, matrix.cy}, {k[0], k[1], k[2], k[3], k[4]}}};
}

void set_fisheye(ForeignLens& lens, const SensorMatrix& matrix, const std::array<double, 4>& k) {
  lens.is_fisheye = true;
  lens.project = [matrix, k](const glm::dvec3& ray) -> std::optional<glm::dvec2> {
    const double off = std::hypot(ray.x, ray.y), theta = std::atan2(off, ray.z), t2 = theta * theta;
    const double slope = 1.0 + t2 * (3.0 * k[0] + t2 * (5.0 * k[1] + t2 * (7.0 * k[2] + t2 * 9.0 * k[3])));
    if (!(slope > 0.0)) return std::nullopt;
    if (off == 0.0) return matrix({0.0, 0.0});
    const double r = theta * (1.0 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))));
    return matrix(glm::dvec2(ray) * (r / off));
  };
  if (matrix.skew == 0.0)
    lens.exact = LensDescription{OpencvFisheyeParameters{{matrix.fx, matrix.fy}, {matrix.cx, matrix.cy}, k}};
}

void set_omnidirectional(ForeignLens& lens, const SensorMatrix& matrix, double xi, const BrownCoefficients& k) {
  lens.is_fisheye = true;
  lens.project = [matrix, xi, k](const glm::dvec3& any_length) -> std::optional<glm::dvec2> {
    const auto ray = glm::normalize(any_length);
    const double depth = ray.z + xi;
    // Beyond -1 / xi the sphere's back lies behind its front.
    if (!(depth > 1e-9) || (xi > 1.0 && ray.z < -1.0 / xi)) return std::nullopt;
    return matrix(brown_distorted({ray.x / depth, ray.y / depth}, k));
  };
}

void set_field_of_view(ForeignLens& lens, const SensorMatrix& matrix, double omega) {
  lens.is_fisheye = true;
  lens.project = [=](const glm::dvec3& ray) -> std::optional<glm::dvec2> {
    if (!(ray.z > 1e-9)) return std::nullopt;
    const double r = std::hypot(ray.x, ray.y) / ray.z;
    const double stretch =
        r < 1e-9 ? 2.0 * std::tan(0.5 * omega) / omega : std::atan(2.0 * r * std::tan(0.5 * omega)) / (omega * r);
    return matrix(glm::dvec2{ray.x, ray.y} / ray.z * stretch);
  };
}

Result<HeldLens> hold(const ForeignLens& lens, Radians largest_angle, const std::string& wanted) {
  const auto may = [&](std::string_view name) { return wanted == "auto" || wanted == name; };
  if (lens.exact && may(model_name(*lens.exact))) {
    auto held = *lens.exact;
    if (lens.is_fisheye) held.largest_angle = largest_angle;
    return HeldLens{held, 0.0};
  }
  const auto seen = seen_directions(lens, largest_angle.value);
  const auto matrix = matrix_on_axis(lens);
  if (seen.size() < 20 || !matrix || !(matrix->fx > 0.0) || !(matrix->fy > 0.0))
    return fail(FaultKind::bad_input, "{}'s {}: no direction falls into the {} x {} picture", lens.program, lens.model,
                lens.width, lens.height);
  std::optional<HeldLens> best;
  const auto consider = [&](const std::optional<LensDescription>& candidate) {
    if (!candidate) return;
    const double moved = most_moved_px(*candidate, seen);
    if (!best || moved < best->moved_px) best = HeldLens{*candidate, moved};
  };
  if (!lens.is_fisheye && may("pinhole"))
    consider(fitted_pinhole(seen, {matrix->fx, matrix->fy}, {matrix->cx, matrix->cy}));
  const bool pinhole_does = best && best->moved_px <= 0.01;
  double farthest = 0.0;
  for (const auto& direction : seen) farthest = std::max(farthest, direction.angle);
  if (farthest > 0.999 * largest_angle.value) farthest = largest_angle.value;
  for (int power = 3; may("scaramuzza") && !pinhole_does && power <= kHighestPower; ++power) {
    if (best && best->moved_px <= 1e-3) break;
    consider(fitted_polynomial(seen, *matrix, power, farthest));
  }
  if (best && best->moved_px <= kMostMovedPx) return *best;
  const auto how =
      best ? fmt::format("would move pixels by up to {:.1f}", best->moved_px) : std::string("holds it not at all");
  return fail(FaultKind::bad_input,
              "{}'s {}: our nearest model{} {}: expected {:.1f} px at most; calibrate without skew "
              "and tangential terms, or from pictures of a board (kasumi calibrate lens)",
              lens.program, lens.model,
              best               ? fmt::format(", {},", model_name(best->lens))
              : wanted == "auto" ? ""
                                 : fmt::format(", {},", wanted),
              how, kMostMovedPx);
}

}  // namespace kasumi
