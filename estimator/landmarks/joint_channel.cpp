#include "estimator/landmarks/joint_channel.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <numeric>
#include <set>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "base/square.hpp"
#include "base/statistics.hpp"

namespace kasumi {
namespace {

using JointVector = Eigen::VectorXd;
using JointMatrix = Eigen::MatrixXd;

constexpr int kGridSteps = 160;  // over asinh of the depth: a likelihood's width takes several steps
constexpr double kLeastDepth = -0.3, kGreatestDepth = 9.0;  // of the farthest, of the nearest
constexpr double kSmallDepth = 0.1;                         // of the farthest: even steps below, even ratios above
// One surface in seven is in the sun, or has a light cloud behind the camera mirrored in it: then it returns more of the
// horizon's light, by some .3. One in fifty is anything (a crane, a blind).
constexpr double kLitOften = 0.14, kLeastLitBy = 0.02, kAnythingOften = 0.02, kAnything = 2.0;
constexpr double kLeastLit = 0.02;             // keeps the variance of a black surface's own light above zero
constexpr double kSettled = 1e-4;              // of contrast
constexpr double kIndependentPictures = 60.0;  // pictures; more of the same surfaces' faults are not more knowledge
constexpr double kLeastToldScatter = 0.4;      // of one picture: what deviates does so for hours
constexpr double kScatterReadings = 12.0;      // the stated scatter counts as so many readings
constexpr double kLeastScatter = 0.25, kGreatestScatter = 5.0;

// The clearest hours: ln of aerosol varies by .7 at a place (AERONET) and by .5 between places; .35 is the sampling of
// hours.
constexpr double kLogSpread = 0.7, kClearestLogSigma = 0.6, kClearestShare = 0.03;

// What the lowest share of a place's hours shows in the mean (nearly the quantile of half of the share), when each was
// read with such an error: errors make hours look clearer that are not. But no less than nothing: errors of neighbouring
// hours are alike.
double clearest_seen(double usual, double share, double sigma) {
  constexpr int kHours = 64;  // in steps of an eighth of a standard deviation
  double low = 0.0, high = usual;
  const auto below = [&](double level) {
    double sum = 0.0;
    for (int k = 0; k < kHours; ++k) {
      // Evenly spread in the normal distribution's logarithm, weighed by its density.
      const double z = -4.0 + 8.0 * (k + 0.5) / kHours;
      const double hour = usual * std::exp(kLogSpread * z);
      const double density = std::exp(-0.5 * z * z) * 8.0 / kHours / std::sqrt(2.0 * std::numbers::pi);
      sum += density * 0.5 * std::erfc((hour - level) / (std::numbers::sqrt2 * sigma));
    }
    return sum;
  };
  for (int i = 0; i < 40; ++i) (below(0.5 * (low + high)) < 0.5 * share ? low : high) = 0.5 * (low + high);
  return 0.5 * (low + high);
}

// Pictures by night or in infrared light do not.
bool shows_air(const ChannelSample& picture) {
  return std::ranges::any_of(picture.readings, &ChannelReading::used);
}

// Hours of one half of a day have much the same air.
double independent_hours(const std::vector<ChannelSample>& pictures) {
  std::set<double> halves;
  double without_time = 0.0;
  for (const auto& picture : pictures)
    if (!shows_air(picture))
      continue;
    else if (picture.day)
      halves.insert(std::floor(2.0 * *picture.day));
    else
      without_time += 0.5;
  return std::max(1.0, static_cast<double>(halves.size()) + without_time);
}

std::vector<double> values_of(const auto& matrix) {
  return std::vector<double>(matrix.data(), matrix.data() + matrix.size());
}

LearntConstants information_of(const ContrastBelief& belief) {
  const auto count = static_cast<Eigen::Index>(belief.mean.size());
  const Eigen::Map<const JointMatrix> covariance(belief.covariance.data(), count, count);
  JointMatrix information = JointMatrix::Zero(2 * count, 2 * count);
  information.topLeftCorner(count, count) = covariance.llt().solve(JointMatrix::Identity(count, count));
  JointVector pull(2 * count);
  pull.head(count) = information.topLeftCorner(count, count) * Eigen::Map<const JointVector>(belief.mean.data(), count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const double floor_sigma = std::max(kLeastFloorSigma, belief.floor_sigma[at]);
    information(count + i, count + i) = 1.0 / square(floor_sigma);
    pull[count + i] = belief.floor[at] / square(floor_sigma);
  }
  return {values_of(information), values_of(pull)};
}

}  // namespace

Plausible plausible(double off, double variance, double kept, const LawOfLandmark& law) {
  const double usual = (1.0 - kLitOften - kAnythingOften) * std::exp(-0.5 * square(off) / variance) /
                       std::sqrt(2.0 * std::numbers::pi * variance);
  const double by = std::max(kLeastLitBy, kLitBy * std::min(1.0, kept));
  const double lit =
      law.before_sky ? kLitOften / by * std::exp(off < 0.0 ? off / by : -0.5 * square(off) / variance) : 0.0;
  const double all = usual + lit + kAnythingOften / kAnything;
  return {usual / all, lit / all, -2.0 * std::log(all)};
}

struct JointChannel::Information {
  JointMatrix matrix;
  JointVector pull, by_constants;  // by_constants: of the extinction
  double sigma_per_m = std::numeric_limits<double>::infinity();
};

double variance_under(double depth, double contrast, double floor, double read_sigma, const LawOfLandmark& law,
                      const ContrastSpread& spread) {
  const double kept = std::exp(-depth);
  // Against the sky a surface's light varies in units of the sky's; between two surfaces their difference varies.
  const double lit = law.before_sky ? std::max(kLeastLit, 1.0 - contrast) : std::abs(contrast);
  const double airlight = law.before_sky ? spread.airlight * (1.0 - std::min(1.0, kept)) : 0.0;
  return square(read_sigma) + square(spread.lit_each * lit * kept) +
         square(spread.patchy * depth * (contrast - floor) * kept) + square(airlight);
}

JointChannel::JointChannel(std::vector<LawOfLandmark> laws, ContrastBelief prior, double clearest_per_m,
                           double usual_aerosol_per_m, const ContrastSpread& spread)
    : laws_(std::move(laws)),
      prior_(std::move(prior)),
      clearest_per_m_(clearest_per_m),
      usual_aerosol_per_m_(usual_aerosol_per_m),
      spread_(spread),
      constants_(prior_.mean),
      scatter_(laws_.size(), 1.0) {
  constants_.insert(constants_.end(), prior_.floor.begin(), prior_.floor.end());
  if (laws_.empty()) return;
  prior_information_ = information_of(prior_);
  const auto [near, far] = std::ranges::minmax(laws_, {}, &LawOfLandmark::path_m);
  const double small = kSmallDepth / far.path_m;
  const double first = std::asinh(kLeastDepth / kSmallDepth), last = std::asinh(kGreatestDepth / near.path_m / small);
  for (int k = 0; k <= kGridSteps; ++k) {
    grid_per_m_.push_back(small * std::sinh(first + (last - first) * k / kGridSteps));
    for (const auto& law : laws_) kept_.push_back(std::exp(-grid_per_m_.back() * law.path_m));
  }
}

double JointChannel::likeliest_per_m(const ChannelSample& picture) const {
  const auto count = laws_.size();
  std::vector<double> costs;
  for (std::size_t k = 0; k < grid_per_m_.size(); ++k) {
    double cost = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
      const auto& reading = picture.readings[i];
      if (!reading.used) continue;
      const double contrast = constants_[i], floor = constants_[count + i], depth = grid_per_m_[k] * laws_[i].path_m;
      const double variance =
          square(scatter_[i]) * variance_under(depth, contrast, floor, reading.sigma, laws_[i], spread_);
      const double off = reading.contrast - floor - (contrast - floor) * kept_[k * count + i];
      cost += plausible(off, variance, kept_[k * count + i], laws_[i]).minus_two_log;
    }
    costs.push_back(cost);
  }
  const auto best = static_cast<std::size_t>(std::ranges::min_element(costs) - costs.begin());
  if (best == 0 || best + 1 == costs.size()) return grid_per_m_[best];
  const double a = costs[best - 1], b = costs[best], c = costs[best + 1], bend = a - 2.0 * b + c;
  const double shift = bend > 0.0 ? 0.5 * (a - c) / bend : 0.0;
  const auto towards = shift > 0.0 ? best + 1 : best - 1;
  return std::lerp(grid_per_m_[best], grid_per_m_[towards], std::abs(shift));
}

JointChannel::Information JointChannel::of(const ChannelSample& picture, double per_m) const {
  const auto count = static_cast<Eigen::Index>(laws_.size());
  JointMatrix by(count, 2 * count);
  by.setZero();
  JointVector weights = JointVector::Zero(count), along = JointVector::Zero(count), off = JointVector::Zero(count);
  double farthest_m = 0.0;
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const auto& reading = picture.readings[at];
    if (!reading.used) continue;
    const double contrast = constants_[at], floor = constants_[at + laws_.size()], depth = per_m * laws_[at].path_m;
    const double kept = std::exp(-depth);
    const double variance =
        square(scatter_[at]) * variance_under(depth, contrast, floor, reading.sigma, laws_[at], spread_);
    off[i] = reading.contrast - floor - (contrast - floor) * kept;
    weights[i] = plausible(off[i], variance, kept, laws_[at]).usual / variance;
    by(i, i) = kept;
    by(i, count + i) = 1.0 - kept;
    along[i] = -laws_[at].path_m * (contrast - floor) * kept;
    farthest_m = std::max(farthest_m, laws_[at].path_m);
  }
  Information found{JointMatrix::Zero(2 * count, 2 * count), JointVector::Zero(2 * count),
                    JointVector::Zero(2 * count)};
  if (farthest_m == 0.0) return found;
  // The extinction is next to unknown, but not wholly: in fog it would be anything.
  const double unknown = 3.0 * std::abs(per_m) + 1.0 / farthest_m;
  const JointVector weighted = weights.cwiseProduct(along);
  const double about = weighted.dot(along), all = about + 1.0 / square(unknown);
  const JointVector across = by.transpose() * weighted;
  const Eigen::Map<const JointVector> constants(constants_.data(), 2 * count);
  found.matrix = by.transpose() * weights.asDiagonal() * by - across * across.transpose() / all;
  const JointVector towards = off + by * constants;
  found.pull = by.transpose() * weights.cwiseProduct(towards) - across * (weighted.dot(towards) / all);
  found.by_constants = -across / all;
  found.sigma_per_m = 1.0 / std::sqrt(all);
  return found;
}

// The gauge: no picture shows whether C0 and all extinctions rise together. But the clearest of many hours have little
// aerosol.
void JointChannel::add_clearest(const std::vector<ChannelSample>& pictures, std::vector<Information>& all) {
  std::vector<std::size_t> order;
  for (std::size_t t = 0; t < pictures.size(); ++t)
    if (shows_air(pictures[t])) order.push_back(t);
  if (order.empty()) return;
  std::ranges::sort(order, {}, [&](std::size_t t) { return per_m_[t]; });
  const auto clearest = std::max<std::size_t>(
      1, static_cast<std::size_t>(std::lround(kClearestShare * static_cast<double>(order.size()))));
  const double share = std::max(kClearestShare, 0.625 / (independent_hours(pictures) + 0.25));
  double mean = 0.0;
  JointVector by = JointVector::Zero(static_cast<Eigen::Index>(constants_.size()));
  for (std::size_t k = 0; k < clearest; ++k) {
    mean += per_m_[order[k]] / static_cast<double>(clearest);
    by += all[order[k]].by_constants / static_cast<double>(clearest);
  }
  std::vector<double> sigmas;
  for (const auto t : order) sigmas.push_back(all[t].sigma_per_m);
  // Of clear ones: those in haze are read less surely.
  const double read = std::max(quantile(std::move(sigmas), 0.25), 0.01 * usual_aerosol_per_m_);
  const double expected = clearest_seen(usual_aerosol_per_m_, std::min(1.0, share), read);
  const double seen = mean - clearest_per_m_;
  const double sigma =
      kClearestLogSigma *
      std::max(clearest_seen(usual_aerosol_per_m_, std::min(1.0, share), 0.01 * usual_aerosol_per_m_), seen);
  const Eigen::Map<const JointVector> constants(constants_.data(), by.size());
  all.push_back(
      {by * by.transpose() / square(sigma), by * ((expected - seen + by.dot(constants)) / square(sigma)), {}});
}

void JointChannel::scale_scatter(const std::vector<ChannelSample>& pictures) {
  const auto count = laws_.size();
  std::vector<double> squares(count, kScatterReadings), readings(count, kScatterReadings);
  for (std::size_t t = 0; t < pictures.size(); ++t) {
    std::vector<double> off(count, 0.0), variance(count, 1.0), along(count, 0.0);
    double information = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
      const auto& reading = pictures[t].readings[i];
      if (!reading.used) continue;
      const double contrast = constants_[i], floor = constants_[count + i], depth = per_m_[t] * laws_[i].path_m;
      variance[i] = variance_under(depth, contrast, floor, reading.sigma, laws_[i], spread_);
      along[i] = laws_[i].path_m * (contrast - floor) * std::exp(-depth);
      off[i] = reading.contrast - floor - (contrast - floor) * std::exp(-depth);
      information += square(along[i] / scatter_[i]) / variance[i];
    }
    for (std::size_t i = 0; i < count; ++i) {
      if (!pictures[t].readings[i].used || !(information > 0.0)) continue;
      // Its own part in the picture's extinction.
      const double left = 1.0 - square(along[i] / scatter_[i]) / variance[i] / information;
      if (left < 0.2) continue;
      const double squared = square(off[i]) / variance[i] / left;
      const double weight =
          plausible(off[i], square(scatter_[i]) * variance[i], std::exp(-per_m_[t] * laws_[i].path_m), laws_[i]).usual;
      squares[i] += weight * squared;
      readings[i] += weight;
    }
  }
  for (std::size_t i = 0; i < count; ++i)
    scatter_[i] = std::clamp(std::sqrt(squares[i] / readings[i]), kLeastScatter, kGreatestScatter);
}

void JointChannel::solve(const std::vector<ChannelSample>& pictures, int most_steps) {
  const auto size = static_cast<Eigen::Index>(constants_.size()), count = size / 2;
  learnt_ = {};
  by_picture_.clear();
  per_m_.assign(pictures.size(), clearest_per_m_);
  if (count == 0) return;
  const Eigen::Map<const JointMatrix> prior(prior_information_.information.data(), size, size);
  const Eigen::Map<const JointVector> towards_prior(prior_information_.pull.data(), size);
  const auto showing = std::ranges::count_if(pictures, shows_air);
  const double share = std::min(1.0, kIndependentPictures / static_cast<double>(std::max<std::ptrdiff_t>(1, showing)));
  std::vector<Information> all;
  JointMatrix sum;
  JointVector pull;
  for (int step = 0; step < most_steps; ++step) {
    all.clear();
    for (std::size_t t = 0; t < pictures.size(); ++t) {
      per_m_[t] = likeliest_per_m(pictures[t]);
      all.push_back(of(pictures[t], per_m_[t]));
    }
    for (auto& one : all) one.matrix *= share, one.pull *= share;
    add_clearest(pictures, all);
    sum = JointMatrix::Zero(size, size);
    pull = JointVector::Zero(size);
    for (const auto& one : all) sum += one.matrix, pull += one.pull;
    JointVector solved = (prior + sum).llt().solve(towards_prior + pull);
    solved.head(count) = solved.head(count).cwiseMin(kDarkest).cwiseMax(-10.0).eval();
    const Eigen::Map<const JointVector> before(constants_.data(), size);
    const double moved = (solved - before).cwiseAbs().maxCoeff();
    std::copy(solved.data(), solved.data() + size, constants_.begin());
    scale_scatter(pictures);
    if (moved < kSettled) break;
  }
  learnt_ = {values_of(sum), values_of(pull)};
  for (std::size_t t = 0; t < pictures.size(); ++t)
    by_picture_.push_back({values_of(all[t].matrix), values_of(all[t].pull)});
}

LearntConstants JointChannel::learnt_without(std::optional<std::size_t> picture) const {
  LearntConstants learnt = learnt_;
  if (!picture || learnt.pull.empty()) return learnt;
  const auto take = [](std::vector<double>& from, const std::vector<double>& what) {
    std::ranges::transform(from, what, from.begin(), std::minus<>());
  };
  take(learnt.information, by_picture_[*picture].information);
  take(learnt.pull, by_picture_[*picture].pull);
  return learnt;
}

ContrastBelief JointChannel::belief_without(std::optional<std::size_t> picture) const {
  ContrastBelief belief = prior_;
  for (std::size_t i = 0; i < scatter_.size(); ++i) belief.scatter[i] = std::max(kLeastToldScatter, scatter_[i]);
  const auto size = static_cast<Eigen::Index>(constants_.size()), count = size / 2;
  const auto learnt = learnt_without(picture);
  if (learnt.pull.empty()) return belief;
  const auto matrix_of = [&](const LearntConstants& one) {
    return Eigen::Map<const JointMatrix>(one.information.data(), size, size);
  };
  const auto vector_of = [&](const LearntConstants& one) {
    return Eigen::Map<const JointVector>(one.pull.data(), size);
  };
  const JointMatrix sum = matrix_of(prior_information_) + matrix_of(learnt);
  const JointVector pull = vector_of(prior_information_) + vector_of(learnt);
  const Eigen::LLT<JointMatrix> factor(sum);
  JointVector mean = factor.solve(pull);
  mean.head(count) = mean.head(count).cwiseMin(kDarkest).eval();
  const JointMatrix covariance = factor.solve(JointMatrix::Identity(size, size));
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto at = static_cast<std::size_t>(i);
    belief.mean[at] = mean[i];
    belief.floor[at] = mean[count + i];
    belief.floor_sigma[at] = std::sqrt(covariance(count + i, count + i));
    for (Eigen::Index j = 0; j < count; ++j)
      belief.covariance[at * laws_.size() + static_cast<std::size_t>(j)] =
          0.5 * (covariance(i, j) + covariance(j, i)) + (i == j ? square(kLeastContrastSigma) : 0.0);
  }
  return belief;
}

}  // namespace kasumi
