#include <algorithm>
#include <cmath>

#include "base/statistics.hpp"
#include "calib/light/response_fit.hpp"
#include "calib/light/response_levels.hpp"

namespace kasumi {
namespace {

struct Scatter {
  double light, error, slope;
};

// Each exposure's light against the prediction by the pixel's other exposures, in units of full scale.
std::vector<Scatter> scatter_of(const StackSamples& samples, const ResponseFit& fit, int channel,
                                const NoiseModel& noise) {
  std::vector<Scatter> all;
  const auto& curve = fit.light[static_cast<std::size_t>(channel)];
  struct Reading {
    double light, s, variance, slope;
  };
  std::vector<Reading> readings;
  for (std::size_t i = 0; i < samples.pixels; ++i) {
    readings.clear();
    double weights = 0.0, sum = 0.0;
    for (std::size_t j = 0; j < samples.exposures; ++j) {
      const double value = samples.at(channel, i, j);
      if (value < 1.5 * samples.quantum || value >= kSaturated) continue;
      const double light = light_at(curve, value), s = std::exp(fit.log_s[j]), slope = slope_at(curve, value);
      const double variance = noise.variance(light) + std::pow(samples.quantum * slope, 2) / 12.0 + 1e-12;
      readings.push_back({light, s, variance, slope});
      weights += s * s / variance;
      sum += s * light / variance;
    }
    if (readings.size() < 2) continue;
    for (const auto& reading : readings) {
      const double others = weights - reading.s * reading.s / reading.variance;
      if (!(others > 1e-9 * weights)) continue;
      const double expected = reading.s * (sum - reading.s * reading.light / reading.variance) / others;
      // The prediction has a variance of its own; only this exposure's share counts.
      const double share = reading.variance / (reading.variance + reading.s * reading.s / others);
      all.push_back({std::max(expected, 1e-6), (reading.light - expected) * std::sqrt(share), reading.slope});
    }
  }
  return all;
}

}  // namespace

std::optional<NoiseModel> fit_noise(const StackSamples& samples, const ResponseFit& fit) {
  NoiseModel noise{1e-4, 1e-6};
  for (int round = 0; round < 6; ++round) {
    std::vector<Scatter> all;
    for (int c = 0; c < 3; ++c) {
      const auto more = scatter_of(samples, fit, c, noise);
      all.insert(all.end(), more.begin(), more.end());
    }
    std::sort(all.begin(), all.end(), [](const Scatter& a, const Scatter& b) { return a.light < b.light; });
    constexpr std::size_t kBins = 24;
    if (all.size() < 50 * kBins) return std::nullopt;
    // variance = shot L + read, each bin weighted by the certainty of its variance.
    double sxx = 0.0, sx = 0.0, s1 = 0.0, sxy = 0.0, sy = 0.0;
    for (std::size_t bin = 0; bin < kBins; ++bin) {
      std::vector<double> off, slopes;
      double light = 0.0;
      const std::size_t from = bin * all.size() / kBins, to = (bin + 1) * all.size() / kBins;
      for (std::size_t k = from; k < to; ++k) {
        off.push_back(all[k].error);
        slopes.push_back(all[k].slope);
        light += all[k].light / static_cast<double>(to - from);
      }
      const double total = std::pow(robust_sigma(std::move(off)), 2);
      const double steps = std::pow(samples.quantum * median(std::move(slopes)), 2) / 12.0;
      const double variance = total - steps, weight = 1.0 / (total * total + 1e-18);
      sxx += weight * light * light;
      sx += weight * light;
      s1 += weight;
      sxy += weight * light * variance;
      sy += weight * variance;
    }
    const double determinant = sxx * s1 - sx * sx;
    double shot = (s1 * sxy - sx * sy) / determinant, read = (sxx * sy - sx * sxy) / determinant;
    if (read < 0.0) {
      read = 0.0;
      shot = sxy / sxx;
    }
    if (!(shot > 0.0)) return std::nullopt;
    noise = {shot, read};
  }
  return noise;
}

}  // namespace kasumi
