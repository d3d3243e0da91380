#include "estimator/landmarks/extinction.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "base/square.hpp"

namespace kasumi {
namespace {

using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

constexpr double kThickest_per_m = 0.3;  // a visibility of 13 m
constexpr int kSteps = 400;              // of the logarithm of extinction: 2.6 % each
// .8 per km: thinner air is even, thicker is patchy (physics 11, "Patches")
constexpr double kMist_per_m = 8e-4;
constexpr double kOneSigma = 1.0, kTwoSigma = 4.0;  // of -2 ln likelihood

Eigen::Map<const Matrix> square_matrix(const std::vector<double>& values, std::size_t side) {
  return {values.data(), static_cast<Eigen::Index>(side), static_cast<Eigen::Index>(side)};
}

}  // namespace

std::vector<LawOfLandmark> laws_of(const std::vector<ContrastLandmark>& landmarks, double camera_altitude_m) {
  std::vector<LawOfLandmark> laws;
  for (const auto& one : landmarks) laws.push_back({haze_path_m(one, camera_altitude_m), !one.against});
  return laws;
}

ContrastBelief belief_before(const std::vector<ContrastLandmark>& landmarks, const ContrastSpread& spread) {
  ContrastBelief belief;
  for (const auto& one : landmarks) {
    belief.mean.push_back(one.contrast);
    belief.floor.push_back(0.0);
    belief.floor_sigma.push_back(one.infinity_sigma);
    belief.scatter.push_back(1.0);
    for (const auto& other : landmarks)
      belief.covariance.push_back(one.contrast_sigma * other.contrast_sigma *
                                  (&one == &other ? 1.0 : spread.known_together));
  }
  return belief;
}

LandmarkExtinction::LandmarkExtinction(const std::vector<ContrastLandmark>& landmarks, double camera_altitude_m,
                                       double clearest_per_m, int channel, const ContrastSpread& spread)
    : laws_(laws_of(landmarks, camera_altitude_m)),
      channel_(channel),
      spread_(spread),
      belief_(belief_before(landmarks, spread)) {
  const double ratio = std::log(kThickest_per_m / clearest_per_m);
  for (int k = 0; k <= kSteps; ++k) grid_per_m_.push_back(clearest_per_m * std::exp(ratio * k / kSteps));
}

struct LandmarkExtinction::Fit {
  std::vector<double> minus_two_log;  // of the likelihood, for each extinction of the grid
  std::size_t best = 0;
};

// -2 ln of what one reading by itself makes of an extinction.
double LandmarkExtinction::plausible_rise(std::size_t landmark, const ContrastReading& reading, double per_m,
                                          Plausible* found) const {
  const auto& law = laws_[landmark];
  const double contrast = belief_.mean[landmark], floor = belief_.floor[landmark], depth = per_m * law.path_m;
  const double kept = std::exp(-depth);
  const double known = belief_.covariance[landmark * (laws_.size() + 1)];
  const double lit = spread_.lit_together * (law.before_sky ? 1.0 - contrast : contrast);
  const double variance = square(belief_.scatter[landmark]) *
                              variance_under(depth, contrast, floor, reading.sigma[channel_], law, spread_) +
                          square(kept) * (known + square(lit)) + square((1.0 - kept) * belief_.floor_sigma[landmark]);
  const auto one = plausible(reading.contrast[channel_] - floor - (contrast - floor) * kept, variance, kept, law);
  if (found) *found = one;
  return one.minus_two_log;
}

std::vector<std::size_t> LandmarkExtinction::usable(const std::vector<ContrastReading>& readings) const {
  std::vector<std::size_t> shaded, lit;
  for (std::size_t i = 0; i < readings.size() && i < laws_.size(); ++i)
    if (readings[i].usable) (readings[i].lit ? lit : shaded).push_back(i);
  return shaded.empty() ? lit : shaded;
}

// readings = floor + haze * (contrast - floor + change of its lighting) + noise; all normal.
LandmarkExtinction::Fit LandmarkExtinction::fit(const std::vector<ContrastReading>& readings,
                                                const std::vector<std::size_t>& used,
                                                const std::vector<std::size_t>& left_out) const {
  const auto count = static_cast<Eigen::Index>(used.size());
  const auto all = square_matrix(belief_.covariance, laws_.size());
  Matrix known(count, count);
  for (Eigen::Index i = 0; i < count; ++i)
    for (Eigen::Index j = 0; j < count; ++j)
      known(i, j) = all(static_cast<Eigen::Index>(used[static_cast<std::size_t>(i)]),
                        static_cast<Eigen::Index>(used[static_cast<std::size_t>(j)]));
  Fit fit;
  fit.minus_two_log.reserve(grid_per_m_.size());
  Vector haze(count), residual(count), lit(count), own(count);
  for (const double per_m : grid_per_m_) {
    for (Eigen::Index i = 0; i < count; ++i) {
      const auto at = used[static_cast<std::size_t>(i)];
      const double contrast = belief_.mean[at], floor = belief_.floor[at], depth = per_m * laws_[at].path_m;
      const auto& reading = readings[at];
      haze[i] = std::exp(-depth);
      residual[i] = reading.contrast[channel_] - floor - (contrast - floor) * haze[i];
      // Against the sky a surface's light varies in units of the sky's; between two surfaces their difference varies.
      lit[i] = spread_.lit_together * haze[i] * (laws_[at].before_sky ? std::max(0.02, 1.0 - contrast) : contrast);
      own[i] = square(belief_.scatter[at]) *
                   variance_under(depth, contrast, floor, reading.sigma[channel_], laws_[at], spread_) +
               square((1.0 - haze[i]) * belief_.floor_sigma[at]);
      if (reading.lit) own[i] += square(kLitBy * haze[i]);
    }
    Matrix covariance = haze.asDiagonal() * known * haze.asDiagonal();
    covariance += lit * lit.transpose();
    covariance.diagonal() += own;
    const Eigen::LLT<Matrix> factor(covariance);
    double sum = 2.0 * factor.matrixLLT().diagonal().array().log().sum() + residual.dot(factor.solve(residual));
    for (const auto at : left_out) sum += plausible_rise(at, readings[at], per_m, nullptr);
    fit.minus_two_log.push_back(sum);
  }
  fit.best = static_cast<std::size_t>(std::ranges::min_element(fit.minus_two_log) - fit.minus_two_log.begin());
  return fit;
}

// Leaves out readings that do not follow the law of the others: in the sun, a car in front, scaffolding.
std::vector<std::size_t> LandmarkExtinction::agreeing(const std::vector<ContrastReading>& readings,
                                                      const std::vector<std::size_t>& usable,
                                                      std::vector<std::size_t>& left_out) const {
  if (usable.size() < 2) return usable;
  double least = std::numeric_limits<double>::infinity(), best = 0.0;
  for (const double per_m : grid_per_m_) {
    double sum = 0.0;
    for (const auto i : usable) sum += plausible_rise(i, readings[i], per_m, nullptr);
    if (sum < least) least = sum, best = per_m;
  }
  std::vector<std::size_t> used;
  for (const auto i : usable) {
    Plausible found;
    plausible_rise(i, readings[i], best, &found);
    (found.usual >= 0.5 ? used : left_out).push_back(i);
  }
  if (!used.empty()) return used;
  left_out.clear();
  return usable;
}

Extinction LandmarkExtinction::estimate(const std::vector<ContrastReading>& readings) const {
  Extinction found;
  const auto used = agreeing(readings, usable(readings), found.left_out);
  found.landmarks = static_cast<int>(used.size());
  if (used.empty()) {
    found.reason = readings.empty() ? "no landmarks" : "no landmark can be used: " + readings.front().reason;
    return found;
  }
  const auto fitted = fit(readings, used, found.left_out);
  const auto& curve = fitted.minus_two_log;
  const auto last = curve.size() - 1;
  // Where the curve first rises by this much on either side of the best value, between two steps of the grid.
  const auto crossing = [&](double rise, bool up) {
    const double level = curve[fitted.best] + rise;
    for (auto k = fitted.best; k != (up ? last : std::size_t{0});) {
      const auto next = up ? k + 1 : k - 1;
      if (curve[next] > level) {
        const double share = (level - curve[k]) / (curve[next] - curve[k]);
        return std::pair(grid_per_m_[k] * std::pow(grid_per_m_[next] / grid_per_m_[k], share), true);
      }
      k = next;
    }
    return std::pair(up ? grid_per_m_[last] : grid_per_m_[0], false);
  };
  found.per_m = grid_per_m_[fitted.best];
  if (fitted.best > 0 && fitted.best < last) {
    // The parabola's minimum, in the logarithm.
    const double a = curve[fitted.best - 1], b = curve[fitted.best], c = curve[fitted.best + 1];
    if (a - 2.0 * b + c > 0.0)
      found.per_m *= std::pow(grid_per_m_[fitted.best + 1] / found.per_m, 0.5 * (a - c) / (a - 2.0 * b + c));
  }
  const auto [low, closed_below] = crossing(kTwoSigma, false);
  const auto [high, closed_above] = crossing(kTwoSigma, true);
  found.lowest_per_m = low;
  found.highest_per_m = high;
  found.sigma_per_m = 0.5 * (crossing(kOneSigma, true).first - crossing(kOneSigma, false).first);
  found.kind = closed_below ? (closed_above ? ExtinctionKind::value : ExtinctionKind::at_least)
                            : (closed_above ? ExtinctionKind::at_most : ExtinctionKind::nothing);
  // The air is not the same everywhere: other paths, or a meter's cubic metre, have as many times more as less.
  const auto patches = [&](double per_m) {
    return spread_.fog_patchy * square(per_m) / (square(per_m) + square(kMist_per_m));
  };
  const double elsewhere = patches(found.per_m);
  const auto reach = [&](double end) { return std::hypot(std::log(end / found.per_m), 2.0 * elsewhere); };
  if (closed_below) found.lowest_per_m = std::max(grid_per_m_[0], found.per_m * std::exp(-reach(low)));
  if (closed_above) found.highest_per_m = found.per_m * std::exp(reach(high));
  if (found.kind == ExtinctionKind::at_least) found.lowest_per_m = low * std::exp(-2.0 * patches(low));
  found.sigma_per_m = std::hypot(found.sigma_per_m, found.per_m * elsewhere);
  double farthest = 0.0, nearest = std::numeric_limits<double>::infinity();
  for (const auto i : used) {
    farthest = std::max(farthest, laws_[i].path_m);
    nearest = std::min(nearest, laws_[i].path_m);
  }
  if (found.kind == ExtinctionKind::at_most)
    found.reason = fmt::format("clearer than landmarks up to {:.1f} km away can measure", farthest / 1e3);
  else if (found.kind == ExtinctionKind::at_least)
    found.reason = fmt::format("hazier than landmarks {:.2f} km away or more can measure", nearest / 1e3);
  else if (found.kind == ExtinctionKind::nothing)
    found.reason = "the landmarks' contrasts are consistent with any air";
  const bool lit = std::ranges::all_of(used, [&](std::size_t i) { return readings[i].lit; });
  if (lit && found.kind == ExtinctionKind::value) {
    found.kind = ExtinctionKind::at_most;
    found.reason = "its landmarks are in the sun, which takes from their contrast as haze does";
  }
  return found;
}

}  // namespace kasumi
