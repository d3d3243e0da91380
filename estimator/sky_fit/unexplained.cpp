#include "estimator/sky_fit/unexplained.hpp"

#include <algorithm>
#include <cmath>

namespace kasumi {
namespace {

// How far over the sky, over the distance from the sun (in ln) and over elevation a model's error stays the same.
constexpr double kAlikeWithin_rad = 0.6, kAlikeWithinLogDistance = 0.7, kAlikeWithinHeight = 0.5;
// Shares of an error's variance that are smooth over place, over the distance from the sun and over height.
constexpr double kShareByPlace = 0.5, kShareByDistance = 0.35, kShareByHeight = 0.15;
constexpr double kAnyGain = 10.0;  // of ln light: not known at all

// Prior and lower bound: the dome itself follows the air that it was fitted to no better.
constexpr std::array<UnexplainedScale, kLightParts> kUsual{{{0.03, 0.01}, {0.015, 0.006}, {0.005, 0.003}}};
constexpr std::array<UnexplainedScale, kLightParts> kLeast{{{0.004, 0.002}, {0.004, 0.002}, {0.002, 0.001}}};
// Weights assume this rough share of an error's deviation (its smooth part being 1); sigmas this share of its variance.
constexpr double kWeighedRough = 3.0, kBelievedRough = 0.2;
// What a model errs is not random: it resembles what another amount would change. Among skies of other aerosols, grounds
// and mixtures amounts were off by this much more (in variance) than random errors of the same size would make them.
constexpr double kBelievedTimes = 2.5;
constexpr double kFarOff = 3.0;    // standard deviations
constexpr double kSettled = 1e-3;  // relative change of a scale: no fit sees less

double matern(double distance, double length) {
  const double x = std::sqrt(3.0) * std::abs(distance) / length;
  return (1.0 + x) * std::exp(-x);
}

double squared(double x) {
  return x * x;
}

}  // namespace

RadianceParts parts_of(std::span<const ReadingPatch> patches) {
  RadianceParts parts;
  for (std::size_t p = 0; p < kLightParts; ++p) {
    parts[p].resize(static_cast<Eigen::Index>(patches.size()));
    for (std::size_t i = 0; i < patches.size(); ++i) {
      double sum = 0.0;
      for (std::size_t c = 0; c < 3; ++c) sum += kPartsOfChannels[p][c] * patches[i].log_light[static_cast<int>(c)];
      parts[p][static_cast<Eigen::Index>(i)] = sum;
    }
  }
  return parts;
}

Unexplained::Unexplained(std::span<const ReadingPatch> patches, const InstrumentDoubt& doubt)
    : parts_(doubt.colours ? kLightParts : 1), scales_(kUsual) {
  const auto n = static_cast<Eigen::Index>(patches.size());
  const auto log_distance = [&](std::size_t i) { return std::log(patches[i].sun_distance + 0.1); };
  const auto height = [&](std::size_t i) { return std::log(std::max(patches[i].direction.z, 0.0) + 0.1); };
  alike_.resize(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j <= i; ++j) {
      const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
      const double apart = angle_between(patches[a].direction, patches[b].direction).value;
      alike_(i, j) = alike_(j, i) =
          kShareByPlace * matern(apart, kAlikeWithin_rad) +
          kShareByDistance * matern(log_distance(a) - log_distance(b), kAlikeWithinLogDistance) +
          kShareByHeight * matern(height(a) - height(b), kAlikeWithinHeight);
    }
  Eigen::VectorXd falloff(n);
  for (Eigen::Index i = 0; i < n; ++i)
    falloff[i] = doubt.vignetting * squared(patches[static_cast<std::size_t>(i)].off_axis);
  // ln(R/G) and ln(B/G) err on their own: in red over blue by both, in green over both by half of either.
  const std::array gains{kAnyGain, std::sqrt(2.0) * doubt.white_balance, std::sqrt(0.5) * doubt.white_balance};
  for (int p = 0; p < parts_; ++p) {
    const auto part = static_cast<std::size_t>(p);
    instrument_[part] = Eigen::MatrixXd::Constant(n, n, squared(gains[part]));
    if (p == 0) instrument_[part] += falloff * falloff.transpose();
    noise_[part] = Eigen::VectorXd::Zero(n);
    for (Eigen::Index i = 0; i < n; ++i)
      for (std::size_t c = 0; c < 3; ++c)
        noise_[part][i] +=
            squared(kPartsOfChannels[part][c]) * patches[static_cast<std::size_t>(i)].variance[static_cast<int>(c)];
  }
  off_ = Eigen::VectorXd::Zero(n);
  factorise();
}

Eigen::MatrixXd Unexplained::covariance(int part, const UnexplainedScale& scale) const {
  const auto p = static_cast<std::size_t>(part);
  Eigen::MatrixXd sum = instrument_[p] + squared(scale.smooth) * alike_;
  sum.diagonal() += noise_[p] + off_;
  sum.diagonal().array() += squared(scale.rough);
  return sum;
}

void Unexplained::factorise() {
  for (int p = 0; p < parts_; ++p)
    factors_[static_cast<std::size_t>(p)].compute(covariance(p, scales_[static_cast<std::size_t>(p)]));
}

double Unexplained::independent() const {
  const auto n = static_cast<double>(alike_.rows());
  const double rough = kBelievedRough, smooth = 1.0 - rough;
  return n * n / (smooth * smooth * alike_.squaredNorm() + n * rough * (2.0 * smooth + rough));
}

Eigen::MatrixXd Unexplained::believed(int part, Eigen::MatrixXd columns) const {
  const auto p = static_cast<std::size_t>(part);
  const double variance = kBelievedTimes * (squared(scales_[p].smooth) + squared(scales_[p].rough));
  Eigen::MatrixXd varied(columns.rows(), columns.cols());
  for (Eigen::Index k = 0; k < columns.cols(); ++k) {
    auto column = columns.col(k);
    factors_[p].matrixU().solveInPlace(column);
    varied.col(k).noalias() = instrument_[p] * column;
    varied.col(k).noalias() += (1.0 - kBelievedRough) * variance * alike_ * column;
    varied.col(k).array() += (noise_[p] + off_).array() * column.array() + kBelievedRough * variance * column.array();
  }
  return columns.transpose() * varied;
}

void Unexplained::learn(const RadianceParts& residuals) {
  for (int p = 0; p < parts_; ++p) {
    const auto part = static_cast<std::size_t>(p);
    for (int turn = 0; turn < 4; ++turn) {
      const Eigen::LLT<Eigen::MatrixXd> factor(covariance(p, scales_[part]));
      Eigen::VectorXd white = residuals[part];
      factor.matrixL().solveInPlace(white);
      const double before = scales_[part].smooth;
      scales_[part].smooth =
          std::max(kLeast[part].smooth, before * std::sqrt(white.squaredNorm() / static_cast<double>(white.size())));
      scales_[part].rough = std::max(kLeast[part].rough, kWeighedRough * scales_[part].smooth);
      if (turn > 0 && std::abs(scales_[part].smooth - before) < kSettled * before) break;
    }
  }
  // A patch against what all others say of it.
  const Eigen::LLT<Eigen::MatrixXd> factor(covariance(0, scales_[0]));
  const Eigen::MatrixXd root = factor.matrixL().solve(Eigen::MatrixXd::Identity(off_.size(), off_.size()));
  const Eigen::VectorXd inverse = root.colwise().squaredNorm();  // its diagonal
  const Eigen::VectorXd pulled = factor.solve(residuals[0]);
  for (Eigen::Index i = 0; i < off_.size(); ++i) {
    const double left_out = pulled[i] / inverse[i];
    if (squared(left_out) * inverse[i] > squared(kFarOff)) off_[i] += squared(left_out);
  }
  factorise();
}

}  // namespace kasumi
