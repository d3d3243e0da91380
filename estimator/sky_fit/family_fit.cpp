#include "estimator/sky_fit/family_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/LU>

#include "base/square.hpp"

namespace kasumi {
namespace {

// Where colour does not determine the exponent it stays near the kind's own; where kinds fit equally well both keep
// their share.
constexpr double kSigmaTilt = 0.3;
constexpr double kMiddleShare = 0.5, kSigmaShare = 0.5;
// Found amounts of skies over another ground, or of another phase function, were off by this share for each standard
// deviation that the doubts took.
constexpr double kDoubtfulShare = 0.07;
constexpr double kGain = 5e-3;            // of the sum of squares, some hundred: steps that gain less are the last
constexpr double kNothing = 0.1 * kGain;  // of the same: a step of which no more is expected is not tried
constexpr double kLowestExponent = -0.5, kHighestExponent = 2.5;

FamilyPoint moved(const FamilyPoint& amount, const Eigen::Vector3d& step) {
  return {amount.place + step[kPlace], amount.tilt + step[kTilt], amount.share + step[kShare]};
}

}  // namespace

WhitenedFamily::WhitenedFamily(const SkyFamily& family, const FamilyTables& tables, std::span<const Direction> patches,
                               const RadianceParts& measured, const Unexplained& unexplained)
    : family_(family),
      tables_(tables),
      patches_(patches),
      unexplained_(unexplained),
      counted_(static_cast<double>(patches.size()) / unexplained.independent()) {
  const auto n = measured[0].size();
  measured_.resize(unexplained.parts() * n);
  for (int p = 0; p < unexplained.parts(); ++p) {
    Eigen::VectorXd white = measured[static_cast<std::size_t>(p)];
    unexplained.whiten(p, white);
    measured_.segment(p * n, n) = white;
  }
}

Eigen::MatrixXd WhitenedFamily::whitened(const std::array<Eigen::MatrixXd, 3>& channels) const {
  const auto n = channels[0].rows();
  Eigen::MatrixXd rows(unexplained_.parts() * n, channels[0].cols());
  for (int p = 0; p < unexplained_.parts(); ++p) {
    Eigen::MatrixXd part = Eigen::MatrixXd::Zero(n, channels[0].cols());
    for (std::size_t c = 0; c < 3; ++c) part += kPartsOfChannels[static_cast<std::size_t>(p)][c] * channels[c];
    unexplained_.whiten(p, part);
    rows.middleRows(p * n, n) = part;
  }
  return rows;
}

void WhitenedFamily::doubt_at(const FamilyPoint& amount, const Eigen::VectorXd& left) {
  if (doubts_.cols() > 0) brighter_ground_ = doubt_squares_.solve(doubts_.transpose() * left)[0];
  doubts_ = whitened(family_.doubts(tables_, amount, patches_, brighter_ground_));
  doubt_squares_.compute(doubts_.transpose() * doubts_ +
                         counted_ * Eigen::MatrixXd::Identity(doubts_.cols(), doubts_.cols()));
}

Eigen::VectorXd WhitenedFamily::left_at(const FamilyPoint& amount) const {
  const auto light = family_.log_light(tables_, amount);
  return measured_ - whitened({light[0], light[1], light[2]});
}

double WhitenedFamily::sum_of(const Eigen::VectorXd& left) const {
  if (doubts_.cols() == 0) return left.squaredNorm();
  const Eigen::VectorXd along = doubts_.transpose() * left;
  return left.squaredNorm() - along.dot(doubt_squares_.solve(along));
}

WhitenedFamily::Squares WhitenedFamily::squares_at(const FamilyPoint& amount, const Eigen::VectorXd& left) const {
  Squares squares;
  auto by_channel = family_.slopes(tables_, amount);
  for (auto& channel : by_channel)
    for (int u = 0; u < kSkyUnknowns; ++u)
      if (!is_free(u)) channel.col(u).setZero();
  const Eigen::MatrixXd slopes = whitened(by_channel);
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

WhitenedFamily::OfUnknowns WhitenedFamily::slope_covariance(const Squares& squares) const {
  const Eigen::MatrixXd by_doubts = doubts_.transpose() * squares.freed;
  OfUnknowns sum = by_doubts.transpose() * by_doubts;
  const auto n = squares.freed.rows() / unexplained_.parts();
  for (int p = 0; p < unexplained_.parts(); ++p) sum += unexplained_.believed(p, squares.freed.middleRows(p * n, n));
  return sum;
}

FamilyPoint WhitenedFamily::kept(FamilyPoint amount) const {
  amount.place = is_free(kPlace) ? std::clamp(amount.place, 0.0, family_.nodes() - 1.0) : given_place_;
  amount.share = is_free(kShare) ? std::clamp(amount.share, 0.0, 1.0) : 0.0;
  const double own = family_.natural_exponent(amount.share);
  if (is_free(kTilt))
    amount.tilt = std::clamp(amount.tilt, kLowestExponent - own, kHighestExponent - own);
  else
    amount.tilt = given_exponent_ ? *given_exponent_ - own : 0.0;
  return amount;
}

double WhitenedFamily::prior(const FamilyPoint& amount) const {
  double sum = 0.0;
  if (is_free(kTilt) || is_free(kShare)) sum += square(amount.tilt / kSigmaTilt);
  if (is_free(kShare)) sum += square((amount.share - kMiddleShare) / kSigmaShare);
  return counted_ * sum;
}
WhitenedFamily::Unknowns WhitenedFamily::stiffness() const {
  return {0.0, is_free(kTilt) ? counted_ / square(kSigmaTilt) : 0.0,
          is_free(kShare) ? counted_ / square(kSigmaShare) : 0.0};
}
WhitenedFamily::Unknowns WhitenedFamily::prior_slope(const FamilyPoint& amount) const {
  return stiffness().cwiseProduct(Unknowns(0.0, amount.tilt, amount.share - kMiddleShare));
}

// Means over all amounts by their probability, on a grid: the range ends, and an optical depth is no linear function of
// the place.
void WhitenedFamily::integrate(FamilyFit& fit, const OfUnknowns& width) const {
  // In this order, each along those before it.
  constexpr std::array kOrder{kShare, kTilt, kPlace};
  OfUnknowns ordered;
  for (int i = 0; i < kSkyUnknowns; ++i)
    for (int j = 0; j < kSkyUnknowns; ++j)
      ordered(i, j) = width(kOrder[static_cast<std::size_t>(i)], kOrder[static_cast<std::size_t>(j)]);
  for (int i = 0; i < kSkyUnknowns; ++i) ordered(i, i) += 1e-12;
  const OfUnknowns root = ordered.llt().matrixL();
  // A blend's grid is coarser: it has one dimension more.
  const double step = is_free(kShare) ? 1.1 : 0.7;
  const int reach = is_free(kShare) ? 3 : 5;
  const auto reach_of = [&](int unknown) { return is_free(unknown) ? reach : 0; };
  double whole = 0.0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d square = Eigen::Matrix3d::Zero();
  const double top = family_.nodes() - 1.0;
  for (int k = -reach_of(kShare); k <= reach_of(kShare); ++k) {
    FamilyPoint amount;
    amount.share = fit.best.share + step * root(0, 0) * k;
    if (is_free(kShare) && (amount.share < 0.0 || amount.share > 1.0)) continue;
    const double own = family_.natural_exponent(amount.share);
    for (int i = -reach_of(kTilt); i <= reach_of(kTilt); ++i) {
      amount.tilt = fit.best.tilt + step * (root(1, 0) * k + root(1, 1) * i);
      if (is_free(kTilt) && (own + amount.tilt < kLowestExponent || own + amount.tilt > kHighestExponent)) continue;
      if (given_exponent_) amount.tilt = *given_exponent_ - own;
      for (int j = -reach_of(kPlace); j <= reach_of(kPlace); ++j) {
        amount.place = fit.best.place + step * (root(2, 0) * k + root(2, 1) * i + root(2, 2) * j);
        if (is_free(kPlace) && (amount.place < 0.0 || amount.place > top)) continue;
        const double weight = std::exp(-0.5 * step * step * (i * i + j * j + k * k));
        const Aerosol aerosol = family_.aerosol_at(amount, own);
        const Eigen::Vector3d value(aerosol.aod_550, aerosol.angstrom_exponent,
                                    family_.turbidity_of(amount, aerosol).value);
        whole += weight;
        mean += weight * value;
        square += weight * value * value.transpose();
      }
    }
  }
  mean /= whole;
  square = square / whole - mean * mean.transpose();
  fit.mean = family_.aerosol_at(fit.best);
  fit.mean.aod_550 = mean[0];
  fit.mean.angstrom_exponent = mean[1];
  // What the doubts take is known in its rough form alone.
  if (is_free(kPlace)) {
    const double doubtful = kDoubtfulShare * kDoubtfulShare * fit.doubts.squaredNorm();
    square(0, 0) += doubtful * mean[0] * mean[0];
    square(2, 2) += doubtful * std::pow(mean[2] - turbidity_of({.aod_550 = 0.0}), 2);
  }
  fit.covariance = {std::max(0.0, square(0, 0)), square(0, 1), std::max(0.0, square(1, 1))};
  fit.turbidity = mean[2];
  fit.sigma_turbidity = std::sqrt(std::max(0.0, square(2, 2)));
  fit.log_volume = std::log(whole) - 0.5 * (prior(fit.best) / counted_ + fit.doubts.squaredNorm());
  if (is_free(kPlace)) fit.log_volume += std::log(step * root(2, 2) / top);
  if (is_free(kTilt)) fit.log_volume += std::log(step * root(1, 1) / kSigmaTilt);
  if (is_free(kShare)) fit.log_volume += std::log(step * root(0, 0));
}

void WhitenedFamily::hold(const GivenAir& known) {
  const bool is_dome = family_.kind().has_value();
  free_ = {!known.aod_550, is_dome && !known.angstrom_exponent, family_.other().has_value()};
  if (is_dome) given_exponent_ = known.angstrom_exponent;
  given_place_ = family_.place_of(known.aod_550.value_or(0.0));
}

WhitenedFamily::Look WhitenedFamily::look(const GivenAir& known, std::span<const FamilyPoint> places) {
  hold(known);
  Look best{{}, std::numeric_limits<double>::infinity()};
  std::array<Eigen::MatrixXd, 3> light;
  for (auto& channel : light)
    channel.resize(static_cast<Eigen::Index>(patches_.size()), static_cast<Eigen::Index>(places.size()));
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto there = family_.log_light(tables_, kept(places[i]));
    for (std::size_t c = 0; c < 3; ++c) light[c].col(static_cast<Eigen::Index>(i)) = there[c];
  }
  const Eigen::MatrixXd left = (-whitened(light)).colwise() + measured_;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const FamilyPoint amount = kept(places[i]);
    const double sum = sum_of(left.col(static_cast<Eigen::Index>(i))) + prior(amount);
    if (sum < best.sum) best = {amount, sum};
  }
  return best;
}

FamilyFit WhitenedFamily::fitted(const GivenAir& known, std::span<const FamilyPoint> begin) {
  // Preetham's and Hosek's, which alone may not be fitted again, have no doubts to lay out.
  const int layouts = family_.kind() ? 2 : 3;
  if (!begin.empty()) return settled(look(known, begin).amount, layouts);
  std::vector<FamilyPoint> everywhere, around;
  for (int x = 0; x < family_.nodes(); ++x) everywhere.push_back({static_cast<double>(x), 0.0});
  const FamilyPoint best = look(known, everywhere).amount;
  for (const double off : {0.0, -1.0, 1.0})
    for (const double tilt : {0.0, -0.4, 0.4})
      if (is_free(kTilt) || (off == 0.0 && tilt == 0.0)) around.push_back({best.place + off, tilt});
  return settled(look(known, around).amount, layouts);
}

FamilyFit WhitenedFamily::fitted_again(const GivenAir& known, const FamilyFit& before) {
  hold(known);
  brighter_ground_ = before.brighter_ground;
  constexpr int kLayouts = 2;  // a picture's air differs from the one before by little
  return settled(before.best, kLayouts);
}

// Gauss and Newton's steps, each shortened until it helps; the doubts are laid out anew where they lead.
FamilyFit WhitenedFamily::settled(const FamilyPoint& from, int layouts) {
  FamilyFit fit;
  fit.best = from;
  Eigen::VectorXd left = left_at(from);
  Squares here;
  double least = 0.0;
  OfUnknowns curvature;
  constexpr int kTurns = 4;  // of Gauss and Newton between two layouts of the doubts
  bool moved_on = false, better = false;
  for (int turn = 0; turn < layouts * kTurns; ++turn) {
    if (turn % kTurns == 0) {
      doubt_at(fit.best, left);
      least = sum_of(left) + prior(fit.best);
    } else if (!better) {
      continue;
    }
    here = squares_at(fit.best, left);
    curvature = here.curvature;
    curvature += stiffness().asDiagonal();
    const Unknowns slope = here.slope + prior_slope(fit.best);
    const Unknowns step = -(curvature + 1e-9 * OfUnknowns::Identity()).inverse() * slope;
    moved_on = better = false;
    if (-slope.dot(step) < kNothing) continue;  // what the whole step would gain
    for (double share = 1.0; share > 0.05 && !better; share *= 0.4) {
      const FamilyPoint next = kept(moved(fit.best, share * step));
      Eigen::VectorXd left_there = left_at(next);
      const double sum = sum_of(left_there) + prior(next);
      if (sum >= least) continue;
      better = least - sum > kGain;
      least = sum;
      fit.best = next;
      left = std::move(left_there);
      moved_on = true;
    }
  }
  if (moved_on) here = squares_at(fit.best, left);
  const auto n = here.left.size() / unexplained_.parts();
  for (int p = 0; p < unexplained_.parts(); ++p)
    fit.part_squares[static_cast<std::size_t>(p)] = here.left.segment(p * n, n).squaredNorm();
  fit.squares = here.sum;
  fit.doubts = here.doubts;
  fit.brighter_ground = brighter_ground_;
  fit.at_edge = is_free(kPlace) && (fit.best.place <= 0.0 || fit.best.place >= family_.nodes() - 1.0);
  // Covariance under the assumed error model, which is smoother than the one used as weights.
  OfUnknowns varying = slope_covariance(here);
  varying += (counted_ * stiffness()).asDiagonal();
  const OfUnknowns inverse = (curvature + 1e-6 * OfUnknowns::Identity()).inverse();
  OfUnknowns width = inverse * varying * inverse;
  for (int u = 0; u < kSkyUnknowns; ++u)
    if (!is_free(u)) width.row(u).setZero(), width.col(u).setZero();
  integrate(fit, width);
  return fit;
}

RadianceParts residuals_of(const SkyFamily& family, const FamilyFit& fit, std::span<const ReadingPatch> patches,
                           const FamilyTables& tables) {
  RadianceParts residuals = parts_of(patches);
  std::vector<Direction> directions;
  for (const ReadingPatch& patch : patches) directions.push_back(patch.direction);
  auto light = family.log_light(tables, fit.best);
  const RadianceDoubts doubts = family.doubts(tables, fit.best, directions, fit.brighter_ground);
  for (std::size_t c = 0; c < 3; ++c) light[c] += doubts[c] * fit.doubts;
  for (std::size_t p = 0; p < kLightParts; ++p)
    for (std::size_t c = 0; c < 3; ++c) residuals[p] -= kPartsOfChannels[p][c] * light[c];
  return residuals;
}

}  // namespace kasumi
