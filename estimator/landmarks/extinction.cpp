#include "estimator/landmarks/extinction.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>

namespace kasumi {
namespace {

using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

constexpr double kThickest_per_m = 0.3;             // a visibility of 13 m
constexpr int kSteps = 400;                         // of the logarithm of extinction: 2.6 % each
constexpr double kBrightest = 10.0;                 // surface, in units of the horizon's light
constexpr double kOneSigma = 1.0, kTwoSigma = 4.0;  // of -2 ln likelihood

Eigen::Map<const Matrix> square_matrix(const std::vector<double>& values, std::size_t side) {
  return {values.data(), static_cast<Eigen::Index>(side), static_cast<Eigen::Index>(side)};
}

}  // namespace

LandmarkExtinction::LandmarkExtinction(const std::vector<ContrastLandmark>& landmarks, double camera_altitude_m,
                                       double clearest_per_m, int channel, const ContrastSpread& spread)
    : channel_(channel), spread_(spread) {
  const auto count = landmarks.size();
  covariance_.resize(count * count);
  for (std::size_t i = 0; i < count; ++i) {
    path_m_.push_back(haze_path_m(landmarks[i], camera_altitude_m));
    before_sky_.push_back(!landmarks[i].against);
    mean_.push_back(landmarks[i].contrast);
    for (std::size_t j = 0; j < count; ++j)
      covariance_[i * count + j] =
          landmarks[i].contrast_sigma * landmarks[j].contrast_sigma * (i == j ? 1.0 : spread.known_together);
  }
  covariance_before_ = covariance_;
  const double ratio = std::log(kThickest_per_m / clearest_per_m);
  for (int k = 0; k <= kSteps; ++k) grid_per_m_.push_back(clearest_per_m * std::exp(ratio * k / kSteps));
}

double LandmarkExtinction::contrast_sigma(std::size_t landmark) const {
  return std::sqrt(covariance_[landmark * mean_.size() + landmark]);
}

struct LandmarkExtinction::Fit {
  std::vector<double> minus_two_log;  // of the likelihood, for each extinction of the grid
  std::size_t best = 0;
};

namespace {

// What one picture's light does to the contrasts, and what the air's patchiness does to them.
struct Readings {
  Vector contrast, path_m, mean, lit;  // lit: the part of the contrast that changes with the light on the surface
  Matrix known;                        // covariance of the mean
  Vector variance;                     // of reading
};

// The model for one extinction: readings = haze * (contrast + change of its lighting) + noise; all normal.
struct LinearModel {
  Vector haze, residual;
  Matrix noise;
};

LinearModel model_under(double extinction_per_m, const Readings& of, const ContrastSpread& spread) {
  LinearModel model;
  const Vector depth = extinction_per_m * of.path_m;
  model.haze = (-depth.array()).exp();
  model.residual = of.contrast - model.haze.cwiseProduct(of.mean);
  const Vector lit = model.haze.cwiseProduct(of.lit);
  const Vector patchy = spread.patchy * depth.cwiseProduct(model.haze).cwiseProduct(of.mean);
  model.noise = spread.lit_together * spread.lit_together * lit * lit.transpose();
  model.noise.diagonal() += of.variance + spread.lit_each * spread.lit_each * lit.cwiseAbs2() + patchy.cwiseAbs2();
  return model;
}

Matrix covariance_of(const LinearModel& model, const Matrix& known) {
  return model.haze.asDiagonal() * known * model.haze.asDiagonal() + model.noise;
}

Readings readings_of(const std::vector<ContrastReading>& readings, const std::vector<std::size_t>& used, int channel,
                     const std::vector<double>& path_m, const std::vector<bool>& before_sky,
                     const std::vector<double>& mean, const std::vector<double>& covariance) {
  const auto count = static_cast<Eigen::Index>(used.size());
  Readings of{Vector(count), Vector(count), Vector(count), Vector(count), Matrix(count, count), Vector(count)};
  const auto all = square_matrix(covariance, mean.size());
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto at = used[static_cast<std::size_t>(i)];
    of.contrast[i] = readings[at].contrast[channel];
    of.variance[i] = readings[at].sigma[channel] * readings[at].sigma[channel];
    of.path_m[i] = path_m[at];
    of.mean[i] = mean[at];
    // Against the sky a surface's light varies in units of the sky's; between two surfaces their difference varies.
    of.lit[i] = before_sky[at] ? std::max(0.02, 1.0 - mean[at]) : std::abs(mean[at]);
    for (Eigen::Index j = 0; j < count; ++j)
      of.known(i, j) = all(static_cast<Eigen::Index>(at), static_cast<Eigen::Index>(used[static_cast<std::size_t>(j)]));
  }
  return of;
}

}  // namespace

std::vector<std::size_t> LandmarkExtinction::usable(const std::vector<ContrastReading>& readings) const {
  std::vector<std::size_t> used;
  for (std::size_t i = 0; i < readings.size() && i < mean_.size(); ++i)
    if (readings[i].usable) used.push_back(i);
  return used;
}

LandmarkExtinction::Fit LandmarkExtinction::fit(const std::vector<ContrastReading>& readings,
                                                const std::vector<std::size_t>& used) const {
  const auto of = readings_of(readings, used, channel_, path_m_, before_sky_, mean_, covariance_);
  Fit fit;
  fit.minus_two_log.reserve(grid_per_m_.size());
  for (const double extinction : grid_per_m_) {
    const auto model = model_under(extinction, of, spread_);
    const Eigen::LLT<Matrix> factor(covariance_of(model, of.known));
    const double determinant = 2.0 * factor.matrixLLT().diagonal().array().log().sum();
    fit.minus_two_log.push_back(determinant + model.residual.dot(factor.solve(model.residual)));
  }
  fit.best = static_cast<std::size_t>(std::min_element(fit.minus_two_log.begin(), fit.minus_two_log.end()) -
                                      fit.minus_two_log.begin());
  return fit;
}

// Leaves out readings that the others do not predict (a car in front, scaffolding, a cloud's shadow), at most a third.
std::vector<std::size_t> LandmarkExtinction::agreeing(const std::vector<ContrastReading>& readings,
                                                      std::vector<std::size_t> used,
                                                      std::vector<std::size_t>* left_out) const {
  const auto fewest = std::max<std::size_t>(3, used.size() - used.size() / 3);
  while (used.size() >= fewest + 1) {
    const auto best = fit(readings, used).best;
    const auto of = readings_of(readings, used, channel_, path_m_, before_sky_, mean_, covariance_);
    const auto model = model_under(grid_per_m_[best], of, spread_);
    const Matrix inverse = covariance_of(model, of.known).inverse();
    const Vector off = (inverse * model.residual).array() / inverse.diagonal().array().sqrt();
    Eigen::Index worst = 0;
    if (off.cwiseAbs().maxCoeff(&worst) <= spread_.far_off) break;
    if (left_out) left_out->push_back(used[static_cast<std::size_t>(worst)]);
    used.erase(used.begin() + worst);
  }
  return used;
}

Extinction LandmarkExtinction::estimate(const std::vector<ContrastReading>& readings) const {
  Extinction found;
  const auto used = agreeing(readings, usable(readings), &found.left_out);
  found.landmarks = static_cast<int>(used.size());
  if (used.empty()) {
    found.reason = readings.empty() ? "no landmarks" : "no landmark can be used: " + readings.front().reason;
    return found;
  }
  const auto fitted = fit(readings, used);
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
  double farthest = 0.0, nearest = std::numeric_limits<double>::infinity();
  for (const auto i : used) {
    farthest = std::max(farthest, path_m_[i]);
    nearest = std::min(nearest, path_m_[i]);
  }
  if (found.kind == ExtinctionKind::at_most)
    found.reason = fmt::format("clearer than landmarks up to {:.1f} km away can measure", farthest / 1e3);
  else if (found.kind == ExtinctionKind::at_least)
    found.reason = fmt::format("hazier than landmarks {:.2f} km away or more can measure", nearest / 1e3);
  else if (found.kind == ExtinctionKind::nothing)
    found.reason = "the landmarks' contrasts are consistent with any air";
  return found;
}

void LandmarkExtinction::learn(const std::vector<ContrastReading>& readings) {
  const auto used = agreeing(readings, usable(readings), nullptr);
  if (used.empty()) return;
  const auto fitted = fit(readings, used);
  const auto of = readings_of(readings, used, channel_, path_m_, before_sky_, mean_, covariance_);
  const auto count = static_cast<Eigen::Index>(mean_.size());
  const Vector mean = Eigen::Map<const Vector>(mean_.data(), count);
  const Matrix known = square_matrix(covariance_, mean_.size());
  Matrix towards(count, static_cast<Eigen::Index>(used.size()));  // covariance of all with those that were read
  for (Eigen::Index j = 0; j < towards.cols(); ++j)
    towards.col(j) = known.col(static_cast<Eigen::Index>(used[static_cast<std::size_t>(j)]));
  // The picture's extinction is unknown: nothing is learnt along the change that another extinction would cause, so
  // that no prior about clear or hazy days enters the contrasts. What remains is how landmarks differ at one distance.
  const double likeliest = grid_per_m_[fitted.best];
  auto model = model_under(likeliest, of, spread_);
  const Vector by_extinction = model.haze.cwiseProduct(of.path_m).cwiseProduct(of.mean);
  const double unknown = 10.0 * std::max(likeliest, 1.0 / of.path_m.maxCoeff());
  model.noise += unknown * unknown * by_extinction * by_extinction.transpose();
  const Eigen::LLT<Matrix> factor(covariance_of(model, of.known));
  const Matrix across = towards * model.haze.asDiagonal();
  const Vector learnt = mean + across * factor.solve(model.residual);
  const Matrix left = known - across * factor.solve(across.transpose());
  Eigen::Map<Vector>(mean_.data(), count) = learnt.cwiseMin(1.0);  // nothing is darker than black
  Eigen::Map<Matrix>(covariance_.data(), count, count) = 0.5 * (left + left.transpose());
}

void LandmarkExtinction::forget(double share) {
  for (std::size_t i = 0; i < covariance_.size(); ++i)
    covariance_[i] += share * (covariance_before_[i] - covariance_[i]);
}

bool LandmarkExtinction::resume(const LearntContrasts& learnt) {
  const auto count = mean_.size();
  if (learnt.mean.size() != count || learnt.covariance.size() != count * count) return false;
  const auto is_contrast = [](double value) { return value >= -kBrightest && value <= 1.0; };
  const auto is_finite = [](double value) { return std::isfinite(value); };
  if (!std::ranges::all_of(learnt.mean, is_contrast) || !std::ranges::all_of(learnt.covariance, is_finite))
    return false;
  const Matrix covariance = square_matrix(learnt.covariance, count);
  if (!covariance.isApprox(covariance.transpose()) || Eigen::LLT<Matrix>(covariance).info() != Eigen::Success)
    return false;
  mean_ = learnt.mean;
  covariance_ = learnt.covariance;
  return true;
}

}  // namespace kasumi
