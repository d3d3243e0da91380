#include "estimator/horizon/clear_horizon.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Dense>
#include <glm/common.hpp>

#include "base/statistics.hpp"

namespace kasumi {
namespace {

constexpr int kTerms = 5;  // constant, two slopes and two curvatures, as kExpected has them
using Terms = Eigen::Matrix<double, kTerms, 1>;

// The largest expected slope and curvature of the clear sky (1 sigma, per radian and per square radian): where clear
// cells lie in a narrow band only, this keeps the surface from diverging outside it.
constexpr std::array<double, kTerms> kExpected{1e3, 2.0, 5.0, 5.0, 20.0};
// Errors of neighbouring cells are correlated: together they count as this many independent measurements of this
// precision.
constexpr double kIndependentMeasurements = 100.0, kMeasurementError = 0.01;

// In log light. In a picture too noisy for the largest tolerance, clear sky cannot be distinguished from clouds.
constexpr double kLeastTolerance = 0.006, kLargestTolerance = 0.015;

Terms terms(double azimuth, double elevation) {
  Terms t;
  t << 1.0, azimuth, azimuth * azimuth, elevation, elevation * elevation;
  return t;
}

double largest(const glm::dvec3& residual) {
  return std::max({std::abs(residual.x), std::abs(residual.y), std::abs(residual.z)});
}

using Cells = std::vector<const HorizonCell*>;

// The cell with the most others within `reach` of its light, and those others. Every n-th cell stands for the rest.
Cells fullest_window(const Cells& cells, double reach) {
  const std::size_t step = std::max<std::size_t>(1, cells.size() / 300);
  const HorizonCell* best = nullptr;
  std::size_t most = 0;
  const auto near = [&](const HorizonCell& a, const HorizonCell& b) {
    return largest(a.log_light - b.log_light) < reach;
  };
  for (std::size_t i = step / 2; i < cells.size(); i += step) {
    std::size_t count = 0;
    for (std::size_t j = step / 2; j < cells.size(); j += step) count += near(*cells[i], *cells[j]) ? 1 : 0;
    if (count > most) {
      most = count;
      best = cells[i];
    }
  }
  Cells members;
  for (const HorizonCell* cell : cells) {
    if (best && near(*cell, *best)) members.push_back(cell);
  }
  return members;
}

// Weighted least squares of all three channels.
void solve(ClearHorizon& surface, const Cells& cells, const std::vector<double>& weights) {
  Eigen::Matrix<double, kTerms, kTerms> normal = Eigen::Matrix<double, kTerms, kTerms>::Zero();
  Eigen::Matrix<double, kTerms, 3> right = Eigen::Matrix<double, kTerms, 3>::Zero();
  double total = 0.0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (weights[i] <= 0.0) continue;
    const Terms t = terms(cells[i]->azimuth, cells[i]->elevation);
    normal += weights[i] * t * t.transpose();
    for (int c = 0; c < 3; ++c) right.col(c) += weights[i] * cells[i]->log_light[c] * t;
    total += weights[i];
  }
  for (int k = 0; k < kTerms; ++k) {
    const double ratio = kMeasurementError / kExpected[static_cast<std::size_t>(k)];
    normal(k, k) += std::max(total, 1e-9) / kIndependentMeasurements * ratio * ratio;
  }
  const Eigen::Matrix<double, kTerms, 3> solved = normal.ldlt().solve(right);
  for (int c = 0; c < 3; ++c)
    for (int k = 0; k < kTerms; ++k) surface.coefficients[c][k] = solved(k, c);
}

// Grows from the cells of `start` to all that agree with the surface through them: Tukey's weights, first wide, then
// narrow.
ClearHorizon grow(const Cells& cells, const Cells& start, double tolerance) {
  ClearHorizon surface;
  solve(surface, start, std::vector<double>(start.size(), 1.0));
  std::vector<double> weights(cells.size());
  // The reach shrinks by a tenth a round, from 4 to 1.5 tolerances in ten; the rest settles.
  constexpr int kRounds = 24;
  for (int round = 0; round < kRounds; ++round) {
    const double reach = tolerance * std::max(1.5, 4.0 * std::pow(0.9, round));
    for (std::size_t i = 0; i < cells.size(); ++i) {
      weights[i] = tukey_weight(largest(surface.residual(*cells[i])) / reach);
    }
    solve(surface, cells, weights);
  }
  surface.tolerance = tolerance;
  std::size_t clear = 0;
  for (const HorizonCell* cell : cells) clear += surface.is_clear(*cell) ? 1 : 0;
  surface.share = static_cast<double>(clear) / static_cast<double>(cells.size());
  return surface;
}

}  // namespace

glm::dvec3 ClearHorizon::log_light(double azimuth, double elevation) const {
  const Terms t = terms(azimuth, elevation);
  glm::dvec3 value{0};
  for (int c = 0; c < 3; ++c)
    for (int k = 0; k < kTerms; ++k) value[c] += coefficients[c][k] * t[k];
  return value;
}

glm::dvec3 ClearHorizon::residual(const HorizonCell& cell) const {
  return cell.log_light - log_light(cell.azimuth, cell.elevation);
}

bool ClearHorizon::is_clear(const HorizonCell& cell) const {
  return largest(residual(cell)) < tolerance;
}

std::optional<ClearHorizon> fit_clear_horizon(const std::vector<HorizonCell>& cells,
                                              const std::vector<std::uint8_t>& use) {
  Cells used;
  int strips = 0;
  std::vector<double> noise;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (use[i] == 0) continue;
    used.push_back(&cells[i]);
    noise.push_back(cells[i].noise);
    strips = std::max(strips, cells[i].strip + 1);
  }
  if (used.size() < 16) return std::nullopt;
  const double tolerance = std::max(3.0 * median(std::move(noise)), kLeastTolerance);
  if (tolerance > kLargestTolerance) return std::nullopt;

  // A narrow view has one light throughout; in a wide one each strip has its own, and the surface follows them.
  const ClearHorizon even = grow(used, fullest_window(used, tolerance), tolerance);
  Cells of_strips;
  for (int s = 0; s < strips; ++s) {
    Cells strip;
    std::copy_if(used.begin(), used.end(), std::back_inserter(strip),
                 [&](const HorizonCell* cell) { return cell->strip == s; });
    const Cells members = fullest_window(strip, tolerance);
    of_strips.insert(of_strips.end(), members.begin(), members.end());
  }
  const ClearHorizon uneven = grow(used, of_strips, tolerance);
  return even.share >= uneven.share ? even : uneven;
}

}  // namespace kasumi
