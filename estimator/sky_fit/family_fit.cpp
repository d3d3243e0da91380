#include "estimator/sky_fit/family_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/LU>

namespace kasumi {
namespace {

// Where colour says nothing of the exponent it stays near the kind's own.
constexpr double kSigmaExponent = 0.3;
// Found amounts of skies over another ground, or of another phase function, were off by this share for each standard
// deviation that the doubts took.
constexpr double kDoubtfulShare = 0.07;
constexpr double kLowestExponent = -0.5, kHighestExponent = 2.5;

}  // namespace

WhitenedFamily::WhitenedFamily(const SkyFamily& family, const std::array<Eigen::MatrixXd, 3>& log_light,
                               std::span<const Direction> patches, const PartsOfLight& measured,
                               const Unexplained& unexplained)
    : family_(family),
      table_(log_light),
      patches_(patches),
      unexplained_(unexplained),
      counted_(static_cast<double>(patches.size()) / unexplained.independent()) {
  const auto n = measured[0].size(), rows = unexplained.parts() * n;
  measured_.resize(rows);
  for (auto& channel : light_) channel = Eigen::MatrixXd::Zero(rows, family.nodes());
  for (int p = 0; p < unexplained.parts(); ++p) {
    const auto part = static_cast<std::size_t>(p);
    Eigen::VectorXd white = measured[part];
    unexplained.whiten(p, white);
    measured_.segment(p * n, n) = white;
    for (std::size_t c = 0; c < 3; ++c) {
      if (kPartsOfChannels[part][c] == 0.0) continue;
      Eigen::MatrixXd channel = kPartsOfChannels[part][c] * log_light[c];
      unexplained.whiten(p, channel);
      light_[c].middleRows(p * n, n) = channel;
    }
  }
}

void WhitenedFamily::doubt_at(const SkyAmount& amount) {
  if (doubts_.cols() > 0) brighter_ground_ = doubt_squares_.solve(doubts_.transpose() * left_at(amount))[0];
  const DoubtsOfLight doubts = family_.doubts(table_, amount, patches_, brighter_ground_);
  const auto n = doubts[0].rows();
  doubts_.resize(measured_.size(), doubts[0].cols());
  for (int p = 0; p < unexplained_.parts(); ++p) {
    Eigen::MatrixXd part = Eigen::MatrixXd::Zero(n, doubts[0].cols());
    for (std::size_t c = 0; c < 3; ++c) part += kPartsOfChannels[static_cast<std::size_t>(p)][c] * doubts[c];
    unexplained_.whiten(p, part);
    doubts_.middleRows(p * n, n) = part;
  }
  doubt_squares_.compute(doubts_.transpose() * doubts_ +
                         counted_ * Eigen::MatrixXd::Identity(doubts_.cols(), doubts_.cols()));
}

Eigen::VectorXd WhitenedFamily::left_at(const SkyAmount& amount) const {
  const auto places = family_.channel_places(amount);
  Eigen::VectorXd left = measured_;
  for (std::size_t c = 0; c < 3; ++c) {
    const CubicTaps taps = cubic_taps(places[c].place, family_.nodes());
    left.noalias() -= light_[c].middleCols<4>(taps.first) * Eigen::Map<const Eigen::Vector4d>(taps.value.data());
  }
  return left;
}

double WhitenedFamily::sum_at(const SkyAmount& amount) const {
  const Eigen::VectorXd left = left_at(amount);
  if (doubts_.cols() == 0) return left.squaredNorm();
  const Eigen::VectorXd along = doubts_.transpose() * left;
  return left.squaredNorm() - along.dot(doubt_squares_.solve(along));
}

WhitenedFamily::Squares WhitenedFamily::squares_at(const SkyAmount& amount) const {
  Squares squares;
  const Eigen::VectorXd left = left_at(amount);
  const auto places = family_.channel_places(amount);
  Eigen::MatrixXd slopes = Eigen::MatrixXd::Zero(left.size(), 2);
  for (std::size_t c = 0; c < 3; ++c) {
    const CubicTaps taps = cubic_taps(places[c].place, family_.nodes());
    const Eigen::VectorXd slope =
        light_[c].middleCols<4>(taps.first) * Eigen::Map<const Eigen::Vector4d>(taps.slope.data());
    slopes.col(0) += places[c].by_place * slope;
    slopes.col(1) += places[c].by_exponent * slope;
  }
  squares.left = left;
  squares.freed = slopes;
  if (doubts_.cols() > 0) {
    squares.doubts = doubt_squares_.solve(doubts_.transpose() * left);
    squares.left -= doubts_ * squares.doubts;
    squares.freed -= doubts_ * doubt_squares_.solve(doubts_.transpose() * slopes);
  }
  squares.sum = squares.left.squaredNorm() + counted_ * squares.doubts.squaredNorm();
  squares.slope = -squares.freed.transpose() * left;
  squares.curvature = slopes.transpose() * squares.freed;
  return squares;
}

Eigen::Matrix2d WhitenedFamily::slope_covariance(const Squares& squares) const {
  const Eigen::MatrixXd by_doubts = doubts_.transpose() * squares.freed;
  Eigen::Matrix2d sum = by_doubts.transpose() * by_doubts;
  const auto n = squares.freed.rows() / unexplained_.parts();
  for (int p = 0; p < unexplained_.parts(); ++p) sum += unexplained_.believed(p, squares.freed.middleRows(p * n, n));
  return sum;
}

FamilyFit WhitenedFamily::fitted(const GivenAir& known) {
  const bool is_dome = family_.kind().has_value();
  const double own = family_.natural_exponent(), top = family_.nodes() - 1.0;
  const bool free_exponent = is_dome && !known.angstrom_exponent;
  const double middle = is_dome && known.angstrom_exponent ? *known.angstrom_exponent : own;
  const bool free_place = !known.aod_550;
  const double given_place = family_.place_of(known.aod_550.value_or(0.0));

  const double stiffness = counted_ / (kSigmaExponent * kSigmaExponent);
  const auto prior = [&](double exponent) { return stiffness * (exponent - middle) * (exponent - middle); };

  FamilyFit fit;
  double least = std::numeric_limits<double>::infinity();
  for (double x = 0.0; x <= top; x += 1.0)
    for (int e = free_exponent ? -1 : 0; e <= (free_exponent ? 1 : 0); ++e) {
      const SkyAmount amount{free_place ? x : given_place, middle + 0.4 * e};
      const double sum = sum_at(amount) + prior(amount.exponent);
      if (sum >= least) continue;
      least = sum;
      fit.best = amount;
    }
  const auto kept = [&](SkyAmount amount) {
    amount.place = free_place ? std::clamp(amount.place, 0.0, top) : given_place;
    amount.exponent = free_exponent ? std::clamp(amount.exponent, kLowestExponent, kHighestExponent) : middle;
    return amount;
  };
  // Gauss and Newton's steps, each shortened until it helps; the doubts are laid out anew where they lead.
  Eigen::Matrix2d curvature;
  constexpr int kLayouts = 3, kTurns = 4;
  bool better = false;
  for (int turn = 0; turn < kLayouts * kTurns; ++turn) {
    if (turn % kTurns == 0) {
      doubt_at(fit.best);
      least = sum_at(fit.best) + prior(fit.best.exponent);
    } else if (!better) {
      continue;
    }
    const Squares here = squares_at(fit.best);
    curvature = here.curvature;
    curvature(1, 1) += stiffness;
    if (!free_exponent) curvature(0, 1) = curvature(1, 0) = 0.0;
    const Eigen::Vector2d slope = here.slope + Eigen::Vector2d(0.0, (fit.best.exponent - middle) * stiffness);
    const Eigen::Vector2d step = -(curvature + 1e-9 * Eigen::Matrix2d::Identity()).inverse() * slope;
    double share = 1.0;
    better = false;
    for (; share > 0.05 && !better; share *= 0.4) {
      const SkyAmount next = kept({fit.best.place + share * step[0], fit.best.exponent + share * step[1]});
      const double sum = sum_at(next) + prior(next.exponent);
      if (sum >= least) continue;
      better = least - sum > 1e-3;
      least = sum;
      fit.best = next;
    }
  }
  const Squares here = squares_at(fit.best);
  const auto n = here.left.size() / unexplained_.parts();
  for (int p = 0; p < unexplained_.parts(); ++p)
    fit.part_squares[static_cast<std::size_t>(p)] = here.left.segment(p * n, n).squaredNorm();
  fit.squares = here.sum;
  fit.doubts = here.doubts;
  fit.brighter_ground = brighter_ground_;
  // How the likeliest varies by the errors believed in, which are smoother than they were weighed.
  Eigen::Matrix2d varying = slope_covariance(here);
  varying(1, 1) += stiffness * counted_;
  if (!free_exponent) varying(0, 1) = varying(1, 0) = 0.0;
  const Eigen::Matrix2d inverse = (curvature + 1e-6 * Eigen::Matrix2d::Identity()).inverse();
  const Eigen::Matrix2d width = inverse * varying * inverse;

  // Sums over a grid: the range ends, and an optical depth is no linear function of the place.
  const double by_exponent = std::sqrt(width(1, 1)), along = width(0, 1) / width(1, 1),
               by_place = std::sqrt(std::max(width(0, 0) - along * width(0, 1), 1e-12));
  constexpr double kStep = 0.7;
  constexpr int kReach = 5;
  double whole = 0.0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d square = Eigen::Matrix3d::Zero();
  for (int i = free_exponent ? -kReach : 0; i <= (free_exponent ? kReach : 0); ++i)
    for (int j = free_place ? -kReach : 0; j <= (free_place ? kReach : 0); ++j) {
      const double tilt = kStep * i * by_exponent;
      const SkyAmount amount{fit.best.place + along * tilt + kStep * j * by_place, fit.best.exponent + tilt};
      const SkyAmount inside = kept(amount);
      if (inside.place != amount.place || inside.exponent != amount.exponent) continue;
      const double weight = std::exp(-0.5 * kStep * kStep * (i * i + j * j));
      const Aerosol aerosol = family_.aerosol_at(amount);
      const Eigen::Vector3d value(aerosol.aod_550, aerosol.angstrom_exponent, family_.turbidity_at(amount).value);
      whole += weight;
      mean += weight * value;
      square += weight * value * value.transpose();
    }
  mean /= whole;
  square = square / whole - mean * mean.transpose();
  fit.mean = family_.aerosol_at(fit.best);
  fit.mean.aod_550 = mean[0];
  fit.mean.angstrom_exponent = mean[1];
  // What the doubts take is known in its rough form alone.
  if (free_place) {
    const double doubtful = kDoubtfulShare * kDoubtfulShare * here.doubts.squaredNorm();
    square(0, 0) += doubtful * mean[0] * mean[0];
    square(2, 2) += doubtful * std::pow(mean[2] - turbidity_of({.aod_550 = 0.0}), 2);
  }
  fit.covariance = {std::max(0.0, square(0, 0)), square(0, 1), std::max(0.0, square(1, 1))};
  fit.turbidity = mean[2];
  fit.sigma_turbidity = std::sqrt(std::max(0.0, square(2, 2)));
  fit.log_volume = std::log(whole) - 0.5 * (prior(fit.best.exponent) / counted_ + here.doubts.squaredNorm());
  if (free_place) fit.log_volume += std::log(kStep * by_place / top);
  if (free_exponent) fit.log_volume += std::log(kStep * by_exponent / kSigmaExponent);
  fit.at_edge = free_place && (fit.best.place <= 0.0 || fit.best.place >= top);
  return fit;
}

PartsOfLight residuals_of(const SkyFamily& family, const FamilyFit& fit, std::span<const SkyPatch> patches,
                          const std::array<Eigen::MatrixXd, 3>& log_light) {
  PartsOfLight residuals = parts_of(patches);
  std::vector<Direction> directions;
  for (const SkyPatch& patch : patches) directions.push_back(patch.direction);
  auto light = family.log_light(log_light, fit.best);
  const DoubtsOfLight doubts = family.doubts(log_light, fit.best, directions, fit.brighter_ground);
  for (std::size_t c = 0; c < 3; ++c) light[c] += doubts[c] * fit.doubts;
  for (std::size_t p = 0; p < kLightParts; ++p)
    for (std::size_t c = 0; c < 3; ++c) residuals[p] -= kPartsOfChannels[p][c] * light[c];
  return residuals;
}

}  // namespace kasumi
