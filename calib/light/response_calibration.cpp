#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include <fmt/format.h>

#include "base/statistics.hpp"
#include "calib/light/response_fit.hpp"
#include "calib/light/response_levels.hpp"

namespace kasumi {
namespace {

constexpr int kHighestOrder = 7;
constexpr std::array kSmoothnesses{1e-2, 1e-3, 1e-4};
constexpr std::size_t kFolds = 4;
constexpr double kAsGood = 1.003;  // about the uncertainty of the cross-validation itself

struct Method {
  bool debevec;
  int order;
  double smoothness;
};

// From the simplest to the most flexible.
std::vector<Method> methods() {
  std::vector<Method> all;
  for (int order = 1; order <= kHighestOrder; ++order) all.push_back({false, order, 0.0});
  for (const double smoothness : kSmoothnesses) all.push_back({true, 0, smoothness});
  return all;
}

std::string name_of(const Method& method) {
  return method.debevec ? fmt::format("Debevec-Malik, smoothness {:g}", method.smoothness)
                        : fmt::format("Mitsunaga-Nayar, order {}", method.order);
}

std::optional<ResponseFit> fit(const Method& method, const StackSamples& samples, const KnownExposures& exposures) {
  return method.debevec ? fit_debevec(samples, exposures, method.smoothness)
                        : fit_mitsunaga(samples, exposures, method.order);
}

StackSamples part_of(const StackSamples& samples, std::size_t fold, bool inside) {
  StackSamples part;
  part.exposures = samples.exposures;
  part.quantum = samples.quantum;
  for (std::size_t i = 0; i < samples.pixels; ++i) {
    if ((i % kFolds == fold) != inside) continue;
    ++part.pixels;
    for (std::size_t c = 0; c < 3; ++c) {
      const auto from = samples.values[c].begin() + static_cast<std::ptrdiff_t>(i * samples.exposures);
      part.values[c].insert(part.values[c].end(), from, from + static_cast<std::ptrdiff_t>(samples.exposures));
    }
  }
  return part;
}

struct SquaredError {
  double sum = 0.0;
  double count = 0.0;
};

// Of each exposure.
std::vector<SquaredError> squared_errors(const StackSamples& samples, const ResponseFit& fit) {
  std::vector<SquaredError> errors(samples.exposures);
  struct Reading {
    double value, light, weight, s;
    std::size_t exposure;
  };
  std::vector<Reading> readings;
  for (int c = 0; c < 3; ++c) {
    const auto& curve = fit.light[static_cast<std::size_t>(c)];
    for (std::size_t i = 0; i < samples.pixels; ++i) {
      readings.clear();
      double weights = 0.0, sum = 0.0;
      for (std::size_t j = 0; j < samples.exposures; ++j) {
        const double value = samples.at(c, i, j);
        if (value < 1.5 * samples.quantum || value >= kSaturated) continue;
        const double s = std::exp(fit.log_s[j]), slope = std::max(slope_at(curve, value), 1e-6);
        const double weight = s * s / (slope * slope);
        readings.push_back({value, light_at(curve, value) / s, weight, s, j});
        weights += weight;
        sum += weight * readings.back().light;
      }
      if (readings.size() < 2) continue;
      for (const auto& reading : readings) {
        const double others = weights - reading.weight;
        if (!(others > 1e-9 * weights)) continue;
        const double predicted = value_at(curve, reading.s * (sum - reading.weight * reading.light) / others);
        const double steps = (reading.value - predicted) / samples.quantum;
        errors[reading.exposure].sum += steps * steps;
        errors[reading.exposure].count += 1.0;
      }
    }
  }
  return errors;
}

// Over all folds; empty when one of them cannot be fitted.
std::optional<double> held_out(const Method& method, const StackSamples& samples, const KnownExposures& exposures) {
  SquaredError all;
  for (std::size_t fold = 0; fold < kFolds; ++fold) {
    const auto fitted = fit(method, part_of(samples, fold, false), exposures);
    if (!fitted) return std::nullopt;
    for (const auto& error : squared_errors(part_of(samples, fold, true), *fitted)) {
      all.sum += error.sum;
      all.count += error.count;
    }
  }
  if (!(all.count > 0.0)) return std::nullopt;
  return std::sqrt(all.sum / all.count);
}

// Light spills over from saturated neighbours, and pictures that were scaled down contain a share of them.
bool touches_saturation(const Image<glm::vec3>& picture, std::size_t pixel, int channel) {
  const int x = static_cast<int>(pixel) % picture.width(), y = static_cast<int>(pixel) / picture.width();
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx)
      if (picture.contains(x + dx, y + dy) && picture.at(x + dx, y + dy)[channel] >= static_cast<float>(kSaturated))
        return true;
  return false;
}

}  // namespace

StackSamples sample_stack(const std::vector<Image<glm::vec3>>& pictures, double quantum, const glm::dvec3& black,
                          const Image<std::uint8_t>& mask, std::size_t count) {
  StackSamples samples;
  samples.exposures = pictures.size();
  samples.quantum = quantum > 0.0 ? quantum : 1.0 / 65535.0;
  const std::size_t size = pictures.front().elements().size();
  std::vector<std::pair<float, std::size_t>> pixels;
  for (std::size_t i = 0; i < size; ++i) {
    if (!mask.empty() && mask.elements()[i] == 0) continue;
    float sum = 0.0f;
    for (const auto& picture : pictures) sum += picture.elements()[i].y;
    pixels.emplace_back(sum, i);
  }
  std::sort(pixels.begin(), pixels.end());
  if (pixels.empty()) return samples;
  constexpr std::size_t kBins = 64;
  const float low = pixels.front().first, high = pixels.back().first;
  const float width = std::max(1e-6f, (high - low) / static_cast<float>(kBins));
  std::mt19937_64 random(1);
  std::vector<std::size_t> chosen;
  auto from = pixels.begin();
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    const float end = low + width * static_cast<float>(bin + 1);
    const auto to =
        bin + 1 == kBins ? pixels.end() : std::lower_bound(from, pixels.end(), std::pair{end, std::size_t{0}});
    const auto here = static_cast<std::size_t>(to - from), wanted = std::max<std::size_t>(1, count / kBins);
    for (std::size_t k = 0; k < std::min(here, wanted); ++k) {
      // The first steps of a Fisher-Yates shuffle.
      const auto other = from + static_cast<std::ptrdiff_t>(k + random() % (here - k));
      std::iter_swap(from + static_cast<std::ptrdiff_t>(k), other);
      chosen.push_back((from + static_cast<std::ptrdiff_t>(k))->second);
    }
    from = to;
  }
  samples.pixels = chosen.size();
  for (int c = 0; c < 3; ++c)
    for (const auto pixel : chosen)
      for (const auto& picture : pictures) {
        const double value = (static_cast<double>(picture.elements()[pixel][c]) - black[c]) / (1.0 - black[c]);
        samples.values[static_cast<std::size_t>(c)].push_back(touches_saturation(picture, pixel, c) ? 1.0 : value);
      }
  return samples;
}

std::vector<std::size_t> by_brightness(const StackSamples& samples) {
  std::vector<double> sums(samples.exposures, 0.0);
  for (std::size_t i = 0; i < samples.pixels; ++i)
    for (std::size_t j = 0; j < samples.exposures; ++j)
      for (int c = 0; c < 3; ++c) sums[j] += samples.at(c, i, j);
  std::vector<std::size_t> order(samples.exposures);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return sums[a] < sums[b]; });
  return order;
}

std::vector<std::optional<double>> linear_ratios(const StackSamples& samples, const std::vector<std::size_t>& order) {
  constexpr std::size_t kFewest = 300;
  std::vector<std::optional<double>> ratios;
  for (std::size_t k = 0; k + 1 < order.size(); ++k) {
    std::vector<double> all;
    for (int c = 0; c < 3; ++c)
      for (std::size_t i = 0; i < samples.pixels; ++i) {
        const double a = samples.at(c, i, order[k + 1]), b = samples.at(c, i, order[k]);
        if (a < kSaturated && a >= 20.0 * samples.quantum && b >= 5.0 * samples.quantum) all.push_back(a / b);
      }
    if (all.size() < kFewest) {
      ratios.push_back(std::nullopt);
      continue;
    }
    ratios.push_back(median_in_place(all));
  }
  return ratios;
}

std::vector<double> prediction_errors(const StackSamples& samples, const ResponseFit& fit) {
  std::vector<double> steps;
  for (const auto& error : squared_errors(samples, fit))
    steps.push_back(error.count > 0.0 ? std::sqrt(error.sum / error.count) : 0.0);
  return steps;
}

Result<ResponseCalibration> calibrate_response(const StackSamples& samples, const KnownExposures& exposures) {
  if (samples.exposures < 2 || samples.pixels < 50)
    return fail(FaultKind::bad_input, "{} pictures, {} pixels: expected at least 2 and 50", samples.exposures,
                samples.pixels);
  ResponseCalibration calibration;
  std::vector<std::pair<Method, double>> fitting;
  for (const auto& method : methods()) {
    const auto error = held_out(method, samples, exposures);
    calibration.candidates.push_back({name_of(method), error});
    if (error) fitting.emplace_back(method, *error);
  }
  if (fitting.empty())
    return fail(FaultKind::bad_input,
                "no rising curve explains the stack: expected one view, held still, in exposures that overlap (each "
                "2 to 4 times the one before), listed with their true times");
  const auto best = std::min_element(fitting.begin(), fitting.end(),
                                     [](const auto& a, const auto& b) { return a.second < b.second; });
  for (const auto& [method, error] : fitting) {
    if (error > kAsGood * best->second) continue;
    auto fitted = fit(method, samples, exposures);
    if (!fitted) continue;
    calibration.fit = std::move(*fitted);
    calibration.held_out_steps = error;
    break;
  }
  if (calibration.fit.method.empty())
    return fail(FaultKind::bad_input, "the curve that predicts best cannot be fitted to all pixels");
  if (!exposures.known)
    calibration.undetermined.push_back(
        "without exposure times, a curve and any power of it (with the ratios to the same power) explain the pictures "
        "equally well; the simplest was taken");
  else if (exposures.sigma > 0.0)
    calibration.undetermined.push_back(fmt::format(
        "exposure times known to {:.1f} % leave the curve's contrast uncertain by as much, divided by the logarithm of "
        "the stack's range",
        100.0 * exposures.sigma));
  return calibration;
}

}  // namespace kasumi
