#include "estimator/fusion/gauss_markov.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace kasumi {
namespace {

constexpr int kGridPoints = 241;          // steps of 1/15 standard deviation
constexpr double kGridReach = 8.0;        // standard deviations on either side
constexpr double kLeastVariance = 1e-12;  // below, a quantity counts as given

}  // namespace

Normal after_observing(const Normal& before, const std::function<double(double)>& log_likelihood) {
  if (before.variance <= kLeastVariance) return before;
  Normal found = before;
  double centre = before.mean, sigma = std::sqrt(before.variance);
  // The second grid is laid over what the first one found, which may be much narrower.
  for (int grid = 0; grid < 2; ++grid) {
    const double step = 2.0 * kGridReach * sigma / (kGridPoints - 1);
    std::array<double, kGridPoints> log_density;
    for (int i = 0; i < kGridPoints; ++i) {
      const double x = centre + step * (i - kGridPoints / 2);
      log_density[static_cast<std::size_t>(i)] =
          log_likelihood(x) - 0.5 * (x - before.mean) * (x - before.mean) / before.variance;
    }
    const double highest = *std::ranges::max_element(log_density);
    double sum = 0.0, first = 0.0, second = 0.0;
    for (int i = 0; i < kGridPoints; ++i) {
      const double offset = step * (i - kGridPoints / 2);
      const double density = std::exp(log_density[static_cast<std::size_t>(i)] - highest);
      sum += density;
      first += density * offset;
      second += density * offset * offset;
    }
    found = {centre + first / sum, std::max(second / sum - first * first / (sum * sum), 0.0)};
    centre = found.mean;
    sigma = std::max(std::sqrt(found.variance), 0.5 * step);
  }
  return {found.mean, std::max(found.variance, kLeastVariance)};
}

double DriftingQuantity::drift_per_root_hour() const {
  return spread * std::sqrt(2.0 * 3600.0 / to_seconds(memory));
}

GaussMarkov::GaussMarkov(std::vector<DriftingQuantity> quantities)
    : quantities_(std::move(quantities)), covariance_(quantities_.size() * quantities_.size(), 0.0) {
  for (std::size_t i = 0; i < size(); ++i) {
    mean_.push_back(quantities_[i].usual);
    covariance_[i * size() + i] = quantities_[i].spread * quantities_[i].spread;
  }
}

Normal GaussMarkov::sum(const Row& row) const {
  Normal found;
  for (std::size_t i = 0; i < size(); ++i) {
    found.mean += row[i] * mean_[i];
    for (std::size_t j = 0; j < size(); ++j) found.variance += row[i] * row[j] * covariance(i, j);
  }
  return {found.mean, std::max(0.0, found.variance)};
}

void GaussMarkov::advance(Duration time) {
  if (time <= Duration{0}) return;
  std::vector<double> kept(size(), 1.0);
  for (std::size_t i = 0; i < size(); ++i)
    if (quantities_[i].spread > 0.0) kept[i] = std::exp(-to_seconds(time) / to_seconds(quantities_[i].memory));
  for (std::size_t i = 0; i < size(); ++i) {
    const DriftingQuantity& one = quantities_[i];
    mean_[i] = one.usual + kept[i] * (mean_[i] - one.usual);
    for (std::size_t j = 0; j < size(); ++j) covariance_[i * size() + j] *= kept[i] * kept[j];
    covariance_[i * size() + i] += one.spread * one.spread * (1.0 - kept[i] * kept[i]);
  }
}

void GaussMarkov::observe(const Row& row, double value, double variance) {
  const Normal before = sum(row);
  const double gain = before.variance / (before.variance + variance);
  condition(row, before, {before.mean + gain * (value - before.mean), (1.0 - gain) * before.variance});
}

void GaussMarkov::condition(const Row& row, const Normal& before, const Normal& after) {
  if (before.variance <= kLeastVariance) return;
  std::vector<double> towards(size(), 0.0);  // covariance of each with the sum
  for (std::size_t i = 0; i < size(); ++i)
    for (std::size_t j = 0; j < size(); ++j) towards[i] += covariance(i, j) * row[j];
  const double moved = (after.mean - before.mean) / before.variance;
  const double narrowed = (before.variance - after.variance) / (before.variance * before.variance);
  for (std::size_t i = 0; i < size(); ++i) {
    mean_[i] += towards[i] * moved;
    for (std::size_t j = 0; j < size(); ++j) covariance_[i * size() + j] -= towards[i] * towards[j] * narrowed;
  }
}

void GaussMarkov::doubt(std::size_t i, double variance) {
  if (quantities_[i].spread > 0.0) covariance_[i * size() + i] += variance;
}

void GaussMarkov::forget(std::size_t i, double kept) {
  const DriftingQuantity& one = quantities_[i];
  mean_[i] = one.usual + kept * (mean_[i] - one.usual);
  for (std::size_t j = 0; j < size(); ++j) {
    covariance_[i * size() + j] *= kept;
    covariance_[j * size() + i] *= kept;
  }
  covariance_[i * size() + i] += one.spread * one.spread * (1.0 - kept * kept);
}

void GaussMarkov::set(std::size_t i, const Normal& known) {
  if (quantities_[i].spread <= 0.0) return;
  for (std::size_t j = 0; j < size(); ++j) covariance_[i * size() + j] = covariance_[j * size() + i] = 0.0;
  mean_[i] = known.mean;
  covariance_[i * size() + i] = known.variance;
}

}  // namespace kasumi
