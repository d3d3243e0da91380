#include "estimator/landmarks/contrast_tone.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>

#include "base/square.hpp"

namespace kasumi {
namespace {

using ToneMatrix = Eigen::MatrixXd;
using ToneVector = Eigen::VectorXd;

// Chosen: of fewer, one odd hour or facade decides.
constexpr std::size_t kFewestPictures = 20, kFewestLandmarks = 4;
constexpr double kLogExponentOfCameras = 0.35;  // as sky_fit/camera_belief has it
constexpr double kLogExtinctionOfHours = 1.2;   // ln of extinction, from hour to hour
constexpr double kLeastLight = 0.004;  // of the horizon's: a surface is never darker, nor are logarithms endless
constexpr double kTails = 4.0;         // degrees of freedom of Student's distribution
constexpr std::size_t kParts = 6;      // of the jackknife: of more parts, each answer would be the same

// Which readings take part.
struct ToneSelection {
  std::size_t without_pictures = kParts, without_landmarks = kParts;  // a sixth; kParts: none
};

class ToneSolution {
 public:
  ToneSolution(const std::vector<ToneSample>& pictures, const std::vector<LawOfLandmark>& laws,
               const ContrastBelief& before, double usual_per_m, const ContrastSpread& spread)
      : pictures_(pictures), laws_(laws), before_(before), spread_(spread), usual_(std::log(usual_per_m)) {
    const auto count = static_cast<Eigen::Index>(laws.size());
    ToneMatrix covariance(count, count);
    for (Eigen::Index i = 0; i < count; ++i)
      for (Eigen::Index k = 0; k < count; ++k)
        covariance(i, k) = before.covariance[static_cast<std::size_t>(i * count + k)];
    prior_ = covariance.llt().solve(ToneMatrix::Identity(count, count));
    contrast_ = ToneVector::Map(before.mean.data(), count);
    for (const auto& picture : pictures) {
      log_per_m_.push_back(std::log(std::max(picture.per_m, 1e-6)));
      lit_.push_back(0.0);
    }
  }

  // From where it stands; returns the cost. The variance of the logarithm of the exponent follows the last step.
  double solve(int steps, const ToneSelection& selection) {
    double cost = 0.0;
    for (int k = 0; k < steps; ++k) cost = step(selection);
    return cost;
  }
  void begin_at(double log_exponent) { log_exponent_ = log_exponent; }
  double log_exponent() const { return log_exponent_; }
  double variance() const { return variance_; }

 private:
  // Gauss-Newton with Student's weights. Of each picture two unknowns are eliminated: the logarithm of its extinction,
  // and by how much more or less light its surfaces return than usual, all alike.
  double step(const ToneSelection& selection) {
    const auto count = static_cast<Eigen::Index>(laws_.size());
    ToneMatrix information = ToneMatrix::Zero(count + 1, count + 1);
    ToneVector pull = ToneVector::Zero(count + 1);
    information.topLeftCorner(count, count) = prior_;
    const ToneVector off = ToneVector::Map(before_.mean.data(), count) - contrast_;
    pull.head(count) = prior_ * off;
    information(count, count) = 1.0 / square(kLogExponentOfCameras);
    pull(count) = -log_exponent_ / square(kLogExponentOfCameras);
    double cost = off.dot(prior_ * off) + square(log_exponent_ / kLogExponentOfCameras);

    struct Eliminated {
      Eigen::Matrix2d inverse;
      Eigen::Vector2d pull;
      Eigen::Matrix<double, 2, Eigen::Dynamic> cross;
    };
    std::vector<Eliminated> all(pictures_.size());
    for (std::size_t t = 0; t < pictures_.size(); ++t) {
      if (t * kParts / pictures_.size() == selection.without_pictures) continue;
      Eigen::Matrix2d own = Eigen::Matrix2d::Zero();
      own(0, 0) = 1.0 / square(kLogExtinctionOfHours);
      own(1, 1) = 1.0 / square(spread_.lit_together);
      Eigen::Vector2d own_pull{(usual_ - log_per_m_[t]) * own(0, 0), -lit_[t] * own(1, 1)};
      cost += square(usual_ - log_per_m_[t]) * own(0, 0) + square(lit_[t]) * own(1, 1);
      Eigen::Matrix<double, 2, Eigen::Dynamic> cross = Eigen::Matrix<double, 2, Eigen::Dynamic>::Zero(2, count + 1);
      for (Eigen::Index i = 0; i < count; ++i) {
        const auto place = static_cast<std::size_t>(i);
        const auto& reading = pictures_[t].readings[place];
        if (!reading.used || !laws_[place].before_sky || place % kParts == selection.without_landmarks) continue;
        const auto seen = slopes(t, place);
        const double variance = variance_of(t, place, reading.sigma, seen.by_contrast);
        const double miss = reading.contrast - seen.contrast, far = square(miss) / variance;
        cost += (kTails + 1.0) * std::log1p(far / kTails) + std::log(variance);
        const double weight = (kTails + 1.0) / (kTails + far) / variance;
        const Eigen::Vector2d by_picture{seen.by_extinction, seen.by_lit};
        const Eigen::Vector2d by_constants{seen.by_without_air, seen.by_exponent};
        own += weight * by_picture * by_picture.transpose();
        own_pull += weight * miss * by_picture;
        cross.col(i) += weight * seen.by_without_air * by_picture;
        cross.col(count) += weight * seen.by_exponent * by_picture;
        information(i, i) += weight * square(seen.by_without_air);
        information(i, count) += weight * seen.by_without_air * seen.by_exponent;
        information(count, i) += weight * seen.by_without_air * seen.by_exponent;
        information(count, count) += weight * square(seen.by_exponent);
        pull(i) += weight * miss * seen.by_without_air;
        pull(count) += weight * miss * seen.by_exponent;
      }
      all[t] = {own.inverse(), own_pull, cross};
      information.noalias() -= cross.transpose() * (all[t].inverse * cross).eval();
      pull -= cross.transpose() * all[t].inverse * own_pull;
    }
    const auto factor = information.ldlt();
    const ToneVector moved = factor.solve(pull);
    variance_ = factor.solve(ToneVector::Unit(count + 1, count))(count);
    constexpr double kMostStep = 0.5;  // of a logarithm
    for (Eigen::Index i = 0; i < count; ++i)
      contrast_(i) = std::clamp(contrast_(i) + std::clamp(moved(i), -0.1, 0.1), 0.2, 1.0);
    log_exponent_ = std::clamp(log_exponent_ + std::clamp(moved(count), -0.2, 0.2), -1.0, 1.0);
    for (std::size_t t = 0; t < pictures_.size(); ++t) {
      if (all[t].cross.cols() == 0) continue;
      const Eigen::Vector2d by = all[t].inverse * (all[t].pull - all[t].cross * moved);
      log_per_m_[t] += std::clamp(by(0), -kMostStep, kMostStep);
      lit_[t] = std::clamp(lit_[t] + by(1), -0.8, 3.0);
    }
    return cost;
  }

  struct ToneSlopes {
    double contrast = 0.0;  // as read
    double by_contrast = 0.0, by_without_air = 0.0, by_extinction = 0.0, by_lit = 0.0, by_exponent = 0.0;
  };
  ToneSlopes slopes(std::size_t t, std::size_t i) const {
    const double depth = std::exp(log_per_m_[t]) * laws_[i].path_m, kept = std::exp(-depth);
    const double without_air = contrast_(static_cast<Eigen::Index>(i));
    const double shown = without_air - (1.0 - without_air) * lit_[t];
    const double light = std::max(kLeastLight, 1.0 - shown * kept), exponent = std::exp(log_exponent_);
    ToneSlopes seen;
    seen.contrast = 1.0 - std::pow(light, exponent);
    seen.by_contrast = exponent * std::pow(light, exponent - 1.0);
    seen.by_without_air = seen.by_contrast * kept * (1.0 + lit_[t]);
    seen.by_extinction = -seen.by_contrast * shown * kept * depth;
    seen.by_lit = -seen.by_contrast * (1.0 - without_air) * kept;
    seen.by_exponent = -exponent * std::pow(light, exponent) * std::log(light);
    return seen;
  }
  double variance_of(std::size_t t, std::size_t i, double read_sigma, double by_contrast) const {
    const double depth = std::exp(log_per_m_[t]) * laws_[i].path_m;
    const double law = variance_under(depth, contrast_(static_cast<Eigen::Index>(i)), 0.0, 0.0, laws_[i], spread_);
    return square(read_sigma) + square(by_contrast) * (law + square(before_.floor_sigma[i]));
  }

  const std::vector<ToneSample>& pictures_;
  const std::vector<LawOfLandmark>& laws_;
  const ContrastBelief& before_;
  const ContrastSpread& spread_;
  double usual_;
  ToneMatrix prior_;
  ToneVector contrast_;  // without air
  std::vector<double> log_per_m_, lit_;
  double log_exponent_ = 0.0, variance_ = 0.0;
};

// Of a jackknife: how far the whole answer would scatter.
double jackknife_variance(const std::vector<double>& without) {
  double mean = 0.0, sum = 0.0;
  for (const double one : without) mean += one / static_cast<double>(without.size());
  for (const double one : without) sum += square(one - mean);
  return sum * (static_cast<double>(without.size()) - 1.0) / static_cast<double>(without.size());
}

}  // namespace

ContrastTone contrast_tone(const std::vector<ToneSample>& pictures, const std::vector<LawOfLandmark>& laws,
                           const ContrastBelief& before, double usual_per_m, const ContrastSpread& spread) {
  const auto skies = static_cast<std::size_t>(std::ranges::count_if(laws, &LawOfLandmark::before_sky));
  if (pictures.size() < kFewestPictures || skies < kFewestLandmarks) return {};
  // Of several beginnings, since the cost may have more than one low.
  std::optional<ToneSolution> best;
  double least = std::numeric_limits<double>::infinity();
  // Of generated cameras: more steps move the logarithm by under .01.
  constexpr int kStepsFromBeginning = 8, kStepsOnward = 2;
  for (const double log_exponent : {-0.2, 0.2}) {
    ToneSolution solution(pictures, laws, before, usual_per_m, spread);
    solution.begin_at(log_exponent);
    if (const double cost = solution.solve(kStepsFromBeginning, {}); cost < least) least = cost, best.emplace(solution);
  }
  if (best) best->solve(kStepsFromBeginning / 2, {});
  if (!best || !std::isfinite(best->variance())) return {};
  std::vector<double> without_pictures, without_landmarks;
  for (std::size_t part = 0; part < kParts; ++part) {
    ToneSolution fewer_pictures = *best;
    fewer_pictures.solve(kStepsOnward, {part, kParts});
    without_pictures.push_back(fewer_pictures.log_exponent());
    if (part >= laws.size()) continue;
    ToneSolution fewer_landmarks = *best;
    fewer_landmarks.solve(kStepsOnward, {kParts, part});
    without_landmarks.push_back(fewer_landmarks.log_exponent());
  }
  ContrastTone tone;
  tone.exponent = std::exp(best->log_exponent());
  tone.pictures = pictures.size();
  const double by_pictures = std::max(best->variance(), jackknife_variance(without_pictures));
  tone.log_sigma = std::min(kLogExponentOfCameras, std::sqrt(by_pictures + jackknife_variance(without_landmarks)));
  return tone;
}

}  // namespace kasumi
