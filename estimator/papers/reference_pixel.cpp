// The papers' estimate, for their tables: one reference pixel, sum of absolute errors, RANSAC (M Eq 8, M14 Sect 3).
// Differences: T stays where the sky model is physical, from 1.7 up (M: from 1), and the one-dimensional search is a
// grid with golden section (M: Levenberg-Marquardt from T = 3, which diverges into the poles below 1.7 when T is 2).
#include "estimator/papers/reference_pixel.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "estimator/turbidity/perez_log.hpp"

namespace kasumi {

namespace {

struct Ratio {
  PerezPoint point;
  double seen = 0.0;  // Y_i / Y_ref
};

double model_ratio(const PerezLog& model, const PerezPoint& point, double log_reference) {
  return std::exp(model.at(point).log_f - log_reference);
}

// Mean absolute error of the ratios at T.
double error_at(double t, std::span<const Ratio> ratios, std::span<const std::size_t> chosen,
                const PerezPoint& reference) {
  const PerezLog model(Turbidity{t});
  const double log_reference = model.at(reference).log_f;
  double sum = 0.0;
  for (const std::size_t i : chosen)
    sum += std::abs(model_ratio(model, ratios[i].point, log_reference) - ratios[i].seen);
  return sum / static_cast<double>(chosen.size());
}

double best_turbidity(std::span<const Ratio> ratios, std::span<const std::size_t> chosen, const PerezPoint& reference) {
  constexpr int kSteps = 28;  // 9 % of T each; the golden section then refines
  const auto node = [](int i) {
    return kLowestTurbidity.value *
           std::pow(kHighestTurbidity.value / kLowestTurbidity.value, static_cast<double>(i) / kSteps);
  };
  int best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= kSteps; ++i) {
    const double error = error_at(node(i), ratios, chosen, reference);
    if (error < least) least = error, best = i;
  }
  constexpr double kGolden = 0.6180339887498949;  // (sqrt(5) - 1) / 2
  double low = node(std::max(0, best - 1)), high = node(std::min(kSteps, best + 1));
  double a = high - kGolden * (high - low), b = low + kGolden * (high - low);
  double fa = error_at(a, ratios, chosen, reference), fb = error_at(b, ratios, chosen, reference);
  while (high - low > 1e-5) {
    if (fa < fb) {
      high = b, b = a, fb = fa;
      a = high - kGolden * (high - low);
      fa = error_at(a, ratios, chosen, reference);
    } else {
      low = a, a = b, fa = fb;
      b = low + kGolden * (high - low);
      fb = error_at(b, ratios, chosen, reference);
    }
  }
  return 0.5 * (low + high);
}

std::vector<std::size_t> some_of(std::size_t all, std::size_t count, std::mt19937_64& random) {
  std::vector<std::size_t> order(all);
  std::iota(order.begin(), order.end(), std::size_t{0});
  for (std::size_t i = 0; i < count; ++i)
    std::swap(order[i], order[i + static_cast<std::size_t>(uniform(random) * static_cast<double>(all - i))]);
  order.resize(count);
  return order;
}

}  // namespace

TurbiditySolution solve_by_reference_pixel(std::span<const LuminanceSample> samples, std::size_t reference,
                                           const RansacPlan& options) {
  TurbiditySolution solution;
  const std::size_t n = samples.size();
  solution.inlier.assign(n, 0);
  if (n < 8 || reference >= n) return solution;
  const auto log_reference_seen = static_cast<double>(samples[reference].log_luminance);
  const PerezPoint reference_point = perez_point(samples[reference]);
  std::vector<Ratio> ratios;
  ratios.reserve(n);
  for (const LuminanceSample& sample : samples)
    ratios.push_back({perez_point(sample), std::exp(static_cast<double>(sample.log_luminance) - log_reference_seen)});

  const auto errors_at = [&](double t) {
    const PerezLog model(Turbidity{t});
    const double log_reference = model.at(reference_point).log_f;
    std::vector<double> errors(n);
    for (std::size_t i = 0; i < n; ++i)
      errors[i] = std::abs(model_ratio(model, ratios[i].point, log_reference) - ratios[i].seen);
    return errors;
  };

  // M14 keeps the inlier set with the smallest error, which favours the smallest sets; an outlier therefore costs the
  // threshold itself.
  std::mt19937_64 random(options.seed);
  const auto count = std::clamp(static_cast<std::size_t>(options.fraction * static_cast<double>(n)), std::size_t{3}, n);
  double least = std::numeric_limits<double>::infinity();
  std::vector<std::size_t> inliers;
  for (int round = 0; round < options.rounds; ++round) {
    const std::vector<double> errors = errors_at(best_turbidity(ratios, some_of(n, count, random), reference_point));
    double cost = 0.0;
    std::vector<std::size_t> good;
    for (std::size_t i = 0; i < n; ++i) {
      cost += std::min(errors[i], options.threshold);
      if (errors[i] < options.threshold) good.push_back(i);
    }
    if (cost < least && good.size() >= 8) least = cost, inliers = std::move(good);
  }
  if (inliers.empty()) return solution;

  solution.turbidity = Turbidity{best_turbidity(ratios, inliers, reference_point)};
  const PerezLog model(solution.turbidity);
  solution.log_gain = log_reference_seen - model.at(reference_point).log_f;
  solution.inliers = static_cast<int>(inliers.size());
  double squares = 0.0, slope = 0.0, slope_squared = 0.0;
  for (const std::size_t i : inliers) {
    solution.inlier[i] = 1;
    const auto [log_f, s] = model.at(ratios[i].point);
    const double r = static_cast<double>(samples[i].log_luminance) - solution.log_gain - log_f;
    squares += r * r;
    slope += s;
    slope_squared += s * s;
  }
  const auto m = static_cast<double>(inliers.size());
  solution.log_residual = std::sqrt(squares / m);
  solution.model_error = solution.log_residual;
  const double information = slope_squared - slope * slope / m;
  constexpr double kEdge = 1e-3;  // of T: what a search within bounds leaves
  solution.at_edge = solution.turbidity.value < kLowestTurbidity.value + kEdge ||
                     solution.turbidity.value > kHighestTurbidity.value - kEdge;
  if (!(information > 0.0)) return solution;
  // From the samples alone: like the papers' method, this ignores the reference pixel's own error.
  solution.sigma = std::sqrt(squares / (m - 2.0) / information);
  solution.solved = true;
  return solution;
}

TurbiditySolver by_reference_pixel(const RansacPlan& options) {
  return [options](std::span<const LuminanceSample> samples) {
    const auto nearest_to_zenith = std::ranges::min_element(samples, {}, &LuminanceSample::zenith) - samples.begin();
    return solve_by_reference_pixel(samples, static_cast<std::size_t>(nearest_to_zenith), options);
  };
}

}  // namespace kasumi
