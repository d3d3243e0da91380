// Consensus first (consensus.hpp), then weighted least squares over the inliers, in double precision.
#include "estimator/turbidity/solver.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/square.hpp"
#include "estimator/turbidity/consensus.hpp"

namespace kasumi {

namespace {

constexpr std::size_t kFewestSamples = 8;  // two unknowns, and enough left over for a sigma
constexpr double kLeastVariance = 1e-10;   // of ln Y: keeps the weights of a noise-free picture's samples finite

// Variable projection: for every T the best ln k is the weighted mean residual, which leaves one unknown.
class LeastSquares {
 public:
  LeastSquares(std::span<const LuminanceSample> samples, const FittedSky& sky)

      : places_(samples, sky),
        lowest_(sky.lowest().value),
        highest_(sky.highest().value),
        residual_(samples.size()),
        slope_(samples.size()) {
    log_y_.reserve(samples.size());
    for (const LuminanceSample& sample : samples) log_y_.push_back(static_cast<double>(sample.log_luminance));
  }

  // ln Y - ln F and d ln F / dT at the T last evaluated.
  const std::vector<double>& residual() const { return residual_; }
  const std::vector<double>& slope() const { return slope_; }

  struct Sums {
    double cost = 0.0, log_gain = 0.0, gradient = 0.0, information = 0.0, mean_slope = 0.0;
  };
  Sums evaluate(std::span<const double> weights, double t) {
    double w = 0.0, ws = 0.0, wr = 0.0, wss = 0.0, wsr = 0.0, wrr = 0.0;
    places_.at(Turbidity{t}, [&](std::size_t i, double log_f, double slope) {
      const double r = log_y_[i] - log_f;
      residual_[i] = r;
      slope_[i] = slope;
      w += weights[i];
      ws += weights[i] * slope;
      wr += weights[i] * r;
      wss += weights[i] * slope * slope;
      wsr += weights[i] * slope * r;
      wrr += weights[i] * r * r;
    });
    if (!(w > 0.0)) return {};
    return {wrr - wr * wr / w, wr / w, wsr - ws * wr / w, wss - ws * ws / w, ws / w};
  }

  // Gauss-Newton in T; afterwards residual() and slope() are those at the result.
  LocalSolution solve(std::span<const double> weights, double start) {
    double t = start;
    Sums now = evaluate(weights, t);
    bool converged = false, current = true;
    // An upper bound: it ends when it has converged.
    constexpr int kRounds = 30;
    for (int round = 0; round < kRounds && !converged && now.information > 0.0; ++round) {
      double next = std::clamp(t + now.gradient / now.information, lowest_, highest_);
      Sums then = evaluate(weights, next);
      for (int halving = 0; halving < 20 && then.cost > now.cost && std::abs(next - t) > 1e-9 * t; ++halving) {
        next = 0.5 * (t + next);
        then = evaluate(weights, next);
      }
      converged = std::abs(next - t) <= 1e-6 * t;
      current = then.cost <= now.cost;
      if (!current) break;  // no step improves the fit any further: rounding
      t = next;
      now = then;
    }
    if (!current) {
      now = evaluate(weights, t);
      converged = true;
    }
    return {Turbidity{t}, now.log_gain, now.information, now.cost, converged};
  }

 private:
  FittedPlaces places_;
  double lowest_, highest_;
  std::vector<double> log_y_, residual_, slope_;
};

// The sky's (zenith angle, sun distance) plane in patches; within one, errors of lens, response and model are
// correlated.
class Patches {
 public:
  Patches(std::span<const LuminanceSample> samples, std::span<const double> weights, const LeastSquares& fit,
          double log_gain, double mean_slope) {
    for (std::size_t i = 0; i < samples.size(); ++i) {
      if (!(weights[i] > 0.0)) continue;
      const int z = std::min(kZenith - 1, static_cast<int>(static_cast<double>(samples[i].zenith) / kSide));
      const int s = std::min(kSun - 1, static_cast<int>(static_cast<double>(samples[i].sun_distance) / kSide));
      Patch& patch = patches_[static_cast<std::size_t>(z) * kSun + static_cast<std::size_t>(s)];
      const double leverage = weights[i] * (fit.slope()[i] - mean_slope);
      patch.leverage += leverage;
      const double r = fit.residual()[i] - log_gain;
      patch.pull += leverage * r;
      patch.sum += r;
      patch.squares += r * r;
      ++patch.count;
    }
  }

  // Standard deviation of T times its information, from the scatter of whole patches instead of single samples.
  double scatter() const {
    const auto used =
        static_cast<double>(std::ranges::count_if(patches_, [](const Patch& patch) { return patch.count > 0; }));
    if (used < 3.0) return std::numeric_limits<double>::infinity();
    double sum = 0.0;
    for (const Patch& patch : patches_) sum += patch.pull * patch.pull;
    return std::sqrt(sum * used / (used - 1.0));
  }

  // Covariance of neighbours' residuals: their mean product, less its expected value by chance. The noise of single
  // samples does not contribute.
  double shared_variance() const {
    double products = 0.0, pairs = 0.0, squares = 0.0, count = 0.0;
    for (const Patch& patch : patches_) {
      products += patch.sum * patch.sum - patch.squares;
      pairs += static_cast<double>(patch.count) * (patch.count - 1);
      squares += patch.squares;
      count += patch.count;
    }
    if (!(pairs > 0.0)) return 0.0;
    return std::max(0.0, products / pairs - squares / count * std::sqrt(2.0 / pairs));
  }

  // The same for an error of the model with this standard deviation that varies smoothly over the sky: the fit absorbs
  // part of it, so the residuals alone would underestimate it.
  double smooth_error(double sigma) const {
    if (!(sigma > 0.0)) return 0.0;
    constexpr double kLength = 0.6 / kSide;  // correlation length in patches
    constexpr double kAbsorbed = 1.3;        // the fit absorbs two of some six degrees of freedom of such an error
    std::array<double, std::max(kZenith, kSun)> near{};
    for (int d = 0; d < static_cast<int>(near.size()); ++d)
      near[static_cast<std::size_t>(d)] = std::exp(-d * d / (2.0 * kLength * kLength));
    double sum = 0.0;
    for (int p = 0; p < kZenith * kSun; ++p) {
      const Patch& a = patches_[static_cast<std::size_t>(p)];
      if (a.count == 0) continue;
      for (int q = 0; q < kZenith * kSun; ++q) {
        const Patch& b = patches_[static_cast<std::size_t>(q)];
        sum += a.leverage * b.leverage * near[static_cast<std::size_t>(std::abs(p / kSun - q / kSun))] *
               near[static_cast<std::size_t>(std::abs(p % kSun - q % kSun))];
      }
    }
    return kAbsorbed * sigma * std::sqrt(std::max(0.0, sum));
  }

 private:
  static constexpr int kZenith = 4, kSun = 8;  // patches of some 20 deg, within which a model's errors are correlated
  static constexpr double kSide = 0.35;        // [rad]
  struct Patch {
    double leverage = 0.0, pull = 0.0, sum = 0.0, squares = 0.0;
    int count = 0;
  };
  std::array<Patch, kZenith * kSun> patches_{};
};

std::vector<double> own_variances(std::span<const LuminanceSample> samples) {
  std::vector<double> own;
  own.reserve(samples.size());
  for (const LuminanceSample& sample : samples) own.push_back(square(static_cast<double>(sample.sigma)));
  return own;
}

double root_mean(const std::vector<double>& variances) {
  return std::sqrt(std::accumulate(variances.begin(), variances.end(), 0.0) / static_cast<double>(variances.size()));
}

// The samples that agree about T, and their joint result.
struct Agreement {
  std::vector<std::uint8_t> inlier;  // one per sample
  int inliers = 0;
  std::vector<double> weights;  // 1 / variance; 0 of those that disagree
  double model_variance = 0.0;
  LocalSolution local;
  bool large_enough() const { return inliers >= static_cast<int>(kFewestSamples); }
};

// Rounds of weighted least squares starting from the consensus. The part of the residuals that the samples' own
// variance (`own`: quantisation and shot noise) does not explain is the model's error, which is the same for all
// samples.
Agreement agree(LeastSquares& fit, const std::vector<double>& own, const Consensus& consensus) {
  const std::size_t n = own.size();
  Agreement agreed;
  agreed.inlier.assign(n, 0);
  agreed.weights.assign(n, 1.0);
  agreed.local = {Turbidity{static_cast<double>(consensus.t)}, static_cast<double>(consensus.log_gain)};
  fit.evaluate(agreed.weights, static_cast<double>(consensus.t));
  constexpr int kRounds = 4;  // of weights and solution by turns; it ends earlier when no sample changes sides
  for (int round = 0; round < kRounds; ++round) {
    double seen = 0.0, known = 0.0;
    bool changed = false;
    agreed.inliers = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const double r = fit.residual()[i] - agreed.local.log_gain;
      // The window is about 2.5 standard deviations.
      const double limit = round == 0 ? 1.2 * static_cast<double>(consensus.window)
                                      : 3.5 * std::sqrt(std::max(kLeastVariance, own[i] + agreed.model_variance));
      const bool inlier = std::abs(r) <= limit;
      changed = changed || inlier != (agreed.inlier[i] != 0);
      agreed.inlier[i] = inlier ? 1 : 0;
      if (!inlier) continue;
      ++agreed.inliers;
      seen += r * r;
      known += own[i];
    }
    if (!agreed.large_enough() || !changed) break;
    agreed.model_variance = std::max(0.0, (seen - known) / agreed.inliers);
    for (std::size_t i = 0; i < n; ++i)
      agreed.weights[i] = agreed.inlier[i] != 0 ? 1.0 / std::max(kLeastVariance, own[i] + agreed.model_variance) : 0.0;
    agreed.local = fit.solve(agreed.weights, agreed.local.turbidity.value);
  }
  return agreed;
}

double rms_of_inliers(const LeastSquares& fit, const Agreement& agreed) {
  double squares = 0.0;
  for (std::size_t i = 0; i < agreed.inlier.size(); ++i)
    if (agreed.inlier[i] != 0) squares += square(fit.residual()[i] - agreed.local.log_gain);
  return std::sqrt(squares / agreed.inliers);
}

// A lower bound of T's standard deviation, set by the picture's quantisation however well its steps seem to fit.
double quantisation_bound(std::span<const LuminanceSample> samples, const LeastSquares& fit, const Agreement& agreed) {
  double q = 0.0, qs = 0.0, qss = 0.0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (agreed.inlier[i] == 0) continue;
    const double s = fit.slope()[i];
    const double quantum = square(static_cast<double>(samples[i].quantisation));
    const double w = quantum > 0.0 ? 1.0 / quantum : 0.0;
    q += w;
    qs += w * s;
    qss += w * s * s;
  }
  const double information = q > 0.0 ? qss - qs * qs / q : 0.0;
  return information > 0.0 ? 1.0 / std::sqrt(information) : 0.0;
}

// Contributions to the error of T; standard deviations.
struct ErrorBudget {
  double residuals = 0.0;     // the scatter of single samples
  double patches = 0.0;       // the scatter of whole patches of the sky
  double model = 0.0;         // an error of the model that varies smoothly over the sky
  double quantisation = 0.0;  // of the picture
  double largest() const { return std::max({residuals, patches, model, quantisation}); }
};

ErrorBudget error_budget(std::span<const LuminanceSample> samples, const LeastSquares& fit, const Agreement& agreed) {
  double chi = 0.0, mean_slope = 0.0, weight = 0.0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (agreed.inlier[i] == 0) continue;
    chi += agreed.weights[i] * square(fit.residual()[i] - agreed.local.log_gain);
    weight += agreed.weights[i];
    mean_slope += agreed.weights[i] * fit.slope()[i];
  }
  const double information = agreed.local.information;
  const Patches patches(samples, agreed.weights, fit, agreed.local.log_gain, mean_slope / weight);
  return {std::sqrt(chi / (agreed.inliers - 2) / information), patches.scatter() / information,
          patches.smooth_error(std::sqrt(patches.shared_variance())) / information,
          quantisation_bound(samples, fit, agreed)};
}

bool is_at_edge(Turbidity turbidity, const FittedSky& sky) {
  constexpr double kEdge = 1e-3;  // of T: what a search within bounds leaves
  return (turbidity.value < kLowestTurbidity.value + kEdge && !sky.dome()) ||
         turbidity.value > sky.highest().value - kEdge;
}

}  // namespace

LocalSolution refine_turbidity(std::span<const LuminanceSample> samples, std::span<const double> weights,
                               Turbidity start, const FittedSky& sky) {
  return LeastSquares(samples, sky).solve(weights, clamp_turbidity(start).value);
}

TurbiditySolution solve_turbidity(std::span<const LuminanceSample> samples, const SolverWindows& options,
                                  const FittedSky& sky) {
  TurbiditySolution solution;
  solution.inlier.assign(samples.size(), 0);
  if (samples.size() < kFewestSamples) return solution;

  const auto own = own_variances(samples);
  const Consensus consensus =
      find_consensus(samples, static_cast<float>(std::max(options.narrowest_window, 2.5 * root_mean(own))),
                     static_cast<float>(options.widest_window), sky);
  if (!std::isfinite(consensus.score)) return solution;

  LeastSquares fit(samples, sky);
  const Agreement agreed = agree(fit, own, consensus);
  solution.inlier = agreed.inlier;
  solution.inliers = agreed.inliers;
  if (!agreed.large_enough()) return solution;

  solution.turbidity = agreed.local.turbidity;
  solution.log_gain = agreed.local.log_gain;
  solution.log_residual = rms_of_inliers(fit, agreed);
  solution.model_error = std::sqrt(agreed.model_variance);
  solution.at_edge = is_at_edge(solution.turbidity, sky);
  if (!(agreed.local.information > 0.0)) return solution;
  solution.sigma = error_budget(samples, fit, agreed).largest();
  solution.solved = std::isfinite(solution.sigma);
  return solution;
}

}  // namespace kasumi
