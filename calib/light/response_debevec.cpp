#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <Eigen/Dense>

#include "calib/light/response_fit.hpp"
#include "calib/light/response_levels.hpp"

namespace kasumi {
namespace {

constexpr auto kLevels = static_cast<Eigen::Index>(kCurveLevels);

// The two levels a value lies between.
struct Between {
  Eigen::Index level;
  double part;
};
Between between(double value) {
  const double at = std::clamp(value, 0.0, 1.0) * static_cast<double>(kLevels - 1);
  const auto level = std::min(static_cast<Eigen::Index>(at), kLevels - 2);
  return {level, at - static_cast<double>(level)};
}

// ln light at the levels of one channel. The pixels' lights are eliminated, so that only the levels are unknown.
Eigen::VectorXd solve_channel(const StackSamples& samples, int channel, const std::vector<double>& log_s,
                              double smoothness) {
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(kLevels, kLevels);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(kLevels);
  struct Row {
    Between at;
    double weight, log_s;
  };
  std::vector<Row> rows;
  double total = 0.0;
  for (std::size_t i = 0; i < samples.pixels; ++i) {
    rows.clear();
    double weights = 0.0, mean_s = 0.0;
    for (std::size_t j = 0; j < samples.exposures; ++j) {
      const double value = samples.at(channel, i, j);
      if (value < 1.5 * samples.quantum || value >= kSaturated) continue;
      const double weight = std::min(value, 1.0 - value);  // the hat
      rows.push_back({between(value), weight, log_s[j]});
      weights += weight;
      mean_s += weight * log_s[j];
    }
    if (rows.size() < 2) continue;
    mean_s /= weights;
    total += weights;
    const auto add = [&](const Between& a, const Between& b, double weight) {
      normal(a.level, b.level) += weight * (1.0 - a.part) * (1.0 - b.part);
      normal(a.level, b.level + 1) += weight * (1.0 - a.part) * b.part;
      normal(a.level + 1, b.level) += weight * a.part * (1.0 - b.part);
      normal(a.level + 1, b.level + 1) += weight * a.part * b.part;
    };
    for (const auto& a : rows) {
      add(a.at, a.at, a.weight);
      for (const auto& b : rows) add(a.at, b.at, -a.weight * b.weight / weights);
      right(a.at.level) += a.weight * (1.0 - a.at.part) * (a.log_s - mean_s);
      right(a.at.level + 1) += a.weight * a.at.part * (a.log_s - mean_s);
    }
  }
  // Second derivative by ln value, integrated over ln value. Level 0 has no logarithm and is not smoothed.
  const double strength = smoothness * total / static_cast<double>(kLevels);
  for (Eigen::Index k = 2; k + 1 < kLevels; ++k) {
    const double before = std::log(static_cast<double>(k) / static_cast<double>(k - 1));
    const double after = std::log(static_cast<double>(k + 1) / static_cast<double>(k));
    const double span = 0.5 * (before + after);
    const std::array row{1.0 / (before * span), -1.0 / (before * span) - 1.0 / (after * span), 1.0 / (after * span)};
    for (Eigen::Index a = 0; a < 3; ++a)
      for (Eigen::Index b = 0; b < 3; ++b)
        normal(k - 1 + a, k - 1 + b) +=
            strength * span * row[static_cast<std::size_t>(a)] * row[static_cast<std::size_t>(b)];
  }
  normal(0, 0) += 1e-6 * total;
  normal(kLevels - 1, kLevels - 1) += 1e-6 * total;  // the gain is arbitrary
  return normal.ldlt().solve(right);
}

// The light of a pixel according to each exposure, weighted by its inverse variance, to which shot noise contributes.
struct PixelLights {
  std::vector<double> weighted, weights;
  double sum = 0.0, total = 0.0;

  void measure(const StackSamples& samples, int channel, std::size_t pixel, const std::vector<double>& log_s,
               const std::vector<double>& light) {
    weighted.assign(samples.exposures, 0.0);
    weights.assign(samples.exposures, 0.0);
    sum = total = 0.0;
    for (std::size_t j = 0; j < samples.exposures; ++j) {
      const double value = samples.at(channel, pixel, j), s = std::exp(log_s[j]);
      if (value < 1.5 * samples.quantum || value >= kSaturated) continue;
      const double here = light_at(light, value), slope = slope_at(light, value) * samples.quantum;
      weights[j] = s * s / (slope * slope + 1e-4 * here);
      weighted[j] = weights[j] * here / s;
      sum += weighted[j];
      total += weights[j];
    }
  }
};

// Averaging the light of a noisy level is biased: the dark levels come out too dark. Averaging the values of a known
// light is not. So the mean value at each light is fitted, with the light taken from the pixel's other exposures. It is
// the curve's value times a factor that is linear between steps of ln light, and smooth where noise dominates.
void undo_noise(const StackSamples& samples, int channel, const std::vector<double>& log_s,
                std::vector<double>& light) {
  constexpr double kStep = 0.125, kDarkest = -9.0, kSmooth = 0.25, kHighest = 0.975, kClipped = 0.985;
  constexpr auto kNodes = static_cast<Eigen::Index>(-kDarkest / kStep) + 1;
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(kNodes, kNodes);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(kNodes);
  const double clipped = light_at(light, kClipped);
  double count = 0.0;
  PixelLights lights;
  for (std::size_t i = 0; i < samples.pixels; ++i) {
    lights.measure(samples, channel, i, log_s, light);
    for (std::size_t j = 0; j < samples.exposures; ++j) {
      const double others = lights.total - lights.weights[j];
      if (!(others > 0.4 * lights.total) || !(lights.total > 0.0)) continue;
      const double here = (lights.sum - lights.weighted[j]) / others * std::exp(log_s[j]);
      const double at = (std::log(here) - kDarkest) / kStep, value = samples.at(channel, i, j);
      // The mean of clipped values is biased, so lights near saturation are left out, whatever their values. So are
      // pixels that touch a saturated one.
      if (!(at >= 0.0) || at >= static_cast<double>(kNodes - 1) || here > clipped || value >= 1.0) continue;
      const auto node = static_cast<Eigen::Index>(at);
      const double part = at - static_cast<double>(node), base = value_at(light, here);
      const double low = (1.0 - part) * base, high = part * base;
      normal(node, node) += low * low;
      normal(node, node + 1) += low * high;
      normal(node + 1, node) += low * high;
      normal(node + 1, node + 1) += high * high;
      right(node) += low * value;
      right(node + 1) += high * value;
      count += 1.0;
    }
  }
  if (!(count > 0.0)) return;
  const double strength = kSmooth * count / static_cast<double>(kNodes);
  for (Eigen::Index k = 1; k + 1 < kNodes; ++k) {
    constexpr std::array row{1.0, -2.0, 1.0};
    for (Eigen::Index a = 0; a < 3; ++a)
      for (Eigen::Index b = 0; b < 3; ++b)
        normal(k - 1 + a, k - 1 + b) += strength * row[static_cast<std::size_t>(a)] * row[static_cast<std::size_t>(b)];
  }
  // Without data the curve stays as it is.
  normal.diagonal().array() += 1e-6 * count;
  right.array() += 1e-6 * count;
  const Eigen::VectorXd factor = normal.ldlt().solve(right);

  // The corrected curve, sampled finely, gives the light of each level.
  std::vector<std::pair<double, double>> curve;  // ln value, ln light
  constexpr int kFine = 8;
  for (Eigen::Index k = 0; k + 1 < kNodes; ++k)
    for (int part = 0; part < kFine; ++part) {
      const double along = static_cast<double>(part) / kFine,
                   log_light = kDarkest + kStep * (static_cast<double>(k) + along);
      const double value = value_at(light, std::exp(log_light)) * ((1.0 - along) * factor(k) + along * factor(k + 1));
      if (value > 0.5 * samples.quantum && (curve.empty() || std::log(value) > curve.back().first))
        curve.emplace_back(std::log(value), log_light);
    }
  if (curve.size() < 2) return;
  const double darkest = std::exp(curve.front().first);
  const auto before = light;
  std::size_t lowest = 0, highest = 0, at = 0;
  for (std::size_t k = 1; k < light.size(); ++k) {
    const double value = static_cast<double>(k) / static_cast<double>(light.size() - 1);
    if (value < darkest || value > kHighest || std::log(value) > curve.back().first) continue;
    while (at + 2 < curve.size() && curve[at + 1].first < std::log(value)) ++at;
    const double part = (std::log(value) - curve[at].first) / (curve[at + 1].first - curve[at].first);
    light[k] = std::exp(curve[at].second + part * (curve[at + 1].second - curve[at].second));
    if (lowest == 0) lowest = k;
    highest = k;
  }
  // Outside this range the curve keeps its shape.
  if (lowest == 0) return;
  for (std::size_t k = 1; k < lowest; ++k) light[k] = before[k] * light[lowest] / before[lowest];
  for (std::size_t k = highest + 1; k < light.size(); ++k) light[k] = before[k] * light[highest] / before[highest];
}

}  // namespace

std::optional<ResponseFit> fit_debevec(const StackSamples& samples, const KnownExposures& exposures,
                                       double smoothness) {
  if (!exposures.known) return std::nullopt;
  ResponseFit fit;
  fit.method = fmt::format("Debevec-Malik, smoothness {:g}", smoothness);
  fit.log_s = exposures.log_s;
  for (int c = 0; c < 3; ++c) {
    const auto log_light = solve_channel(samples, c, exposures.log_s, smoothness);
    std::vector<double> light(kCurveLevels, 0.0);
    for (std::size_t k = 1; k < kCurveLevels; ++k) light[k] = std::exp(log_light(static_cast<Eigen::Index>(k)));
    if (!make_curve(light)) return std::nullopt;
    // Lights are in units in which the last level is 1.
    undo_noise(samples, c, exposures.log_s, light);
    if (!make_curve(light)) return std::nullopt;
    fit.light[static_cast<std::size_t>(c)] = std::move(light);
  }
  return fit;
}

}  // namespace kasumi
