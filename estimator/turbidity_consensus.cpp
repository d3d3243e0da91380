// The hot path, in single precision and without branches in its loops, so that compilers make vector code of them.
#include "estimator/turbidity_consensus.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "estimator/sky_model.hpp"

namespace kasumi {

namespace {

// Coarse where T hardly changes the sky: steps of about 0.03 in ln F. Each run of equal steps needs two exponentials
// per sample in all, since B and D are linear in T.
struct Run {
  double first, step;
  int count;
};
constexpr std::array<Run, 6> kGrid{
    {{1.70, 0.02, 16}, {2.02, 0.04, 12}, {2.50, 0.10, 8}, {3.30, 0.25, 8}, {5.30, 0.80, 5}, {9.30, 2.14, 6}}};

// Background density of samples that fit nothing: they lie anywhere in this range of ln Y.
constexpr float kBackgroundRange = 3.0f;

// Cephes' logf and expf without branches, so that loops over samples become vector code. Relative error 1e-7 for
// positive normal numbers, exponents within +-80.
inline float fast_log(float x) {
  const int bits = std::bit_cast<int>(x);
  const int exponent = (bits - 0x3f3504f3) >> 23;
  const float m = std::bit_cast<float>(bits - exponent * (1 << 23)) - 1.0f;
  float p = 7.0376836292e-2f;
  p = p * m - 1.1514610310e-1f;
  p = p * m + 1.1676998740e-1f;
  p = p * m - 1.2420140846e-1f;
  p = p * m + 1.4249322787e-1f;
  p = p * m - 1.6668057665e-1f;
  p = p * m + 2.0000714765e-1f;
  p = p * m - 2.4999993993e-1f;
  p = p * m + 3.3333331174e-1f;
  return m + m * m * (m * p - 0.5f) + static_cast<float>(exponent) * 0.693147181f;
}
inline float fast_exp(float x) {
  constexpr float kRound = 12582912.0f;  // adding it leaves the nearest integer in the low bits
  const float shifted = x * 1.44269504f + kRound;
  const float n = shifted - kRound;
  const float r = (x - n * 0.693359375f) + n * 2.12194440e-4f;
  float p = 1.9875691500e-4f;
  p = p * r + 1.3981999507e-3f;
  p = p * r + 8.3334519073e-3f;
  p = p * r + 4.1665795894e-2f;
  p = p * r + 1.6666665459e-1f;
  p = p * r + 5.0000001201e-1f;
  p = p * r * r + r + 1.0f;
  return p * std::bit_cast<float>((static_cast<int>(n) + 127) * (1 << 23));
}

// The samples as columns.
class Columns {
 public:
  explicit Columns(std::span<const SkySample> samples) : n_(samples.size()), data_(8 * samples.size()) {
    for (std::size_t i = 0; i < n_; ++i) {
      const SkySample& s = samples[i];
      const float cosine = std::cos(s.sun_distance);
      per_cosine()[i] = 1.0f / std::max(static_cast<float>(kSmallestCosine), std::cos(s.zenith));
      gamma()[i] = s.sun_distance;
      cos2_gamma()[i] = cosine * cosine;
      log_y()[i] = s.log_luminance;
    }
  }
  std::size_t size() const { return n_; }
  float* per_cosine() { return data_.data(); }
  float* gamma() { return data_.data() + n_; }
  float* cos2_gamma() { return data_.data() + 2 * n_; }
  float* log_y() { return data_.data() + 3 * n_; }
  float* residual() { return data_.data() + 4 * n_; }
  float* slope() { return data_.data() + 5 * n_; }  // d ln F / dT; two columns of scratch for the grid
  float* scratch() { return data_.data() + 6 * n_; }

 private:
  std::size_t n_;
  std::vector<float> data_;
};

// Log likelihood of n of all samples lying in a window of this half width and the rest anywhere: rewards many, and
// narrow. It is what lets the data choose the window.
inline float agreement(float n, float all, float half_width) {
  const float rest = all - n;
  const float inside = n > 0.0f ? n * fast_log(n / (all * 2.0f * half_width)) : 0.0f;
  const float outside = rest > 0.0f ? rest * fast_log(rest / (all * kBackgroundRange)) : 0.0f;
  return inside + outside;
}

// Fullest window among the residuals, for a few widths at once. Sixteen bits hold the counts, for eight of them fit a
// vector register.
class Histogram {
 public:
  Consensus fullest(const float* residual, std::size_t n, float t) {
    constexpr std::size_t kSome = 16;  // enough to know where the residuals are
    float middle = 0.0f;
    for (std::size_t i = 0; i < kSome; ++i) middle += residual[i * n / kSome];
    const float origin = middle / static_cast<float>(kSome) - 0.5f * kBins * kBin;

    bin_.resize(n);
    for (std::size_t i = 0; i < n; ++i)
      bin_[i] = static_cast<int>(
          std::min(std::max((residual[i] - origin) * (1.0f / kBin), 0.0f), static_cast<float>(kBins - 1)));
    std::array<std::int16_t, kBins> count{};
    for (std::size_t i = 0; i < n; ++i) ++count[static_cast<std::size_t>(bin_[i])];
    std::array<std::int16_t, kBins + 1> below{};
    int sum = 0;
    for (std::size_t i = 0; i < kBins; ++i) {
      sum += count[i];
      below[i + 1] = static_cast<std::int16_t>(sum);
    }

    Consensus best;
    std::size_t best_width = 1;
    std::int16_t best_count = 0;
    for (const std::size_t width : {1u, 2u, 4u, 8u}) {
      std::int16_t most = 0;
      for (std::size_t i = 0; i + width <= kBins; ++i)
        most = std::max(most, static_cast<std::int16_t>(below[i + width] - below[i]));
      const float half_width = 0.5f * static_cast<float>(width) * kBin;
      const float score = agreement(static_cast<float>(most), static_cast<float>(n), half_width);
      if (score <= best.score) continue;
      best = {t, 0.0f, half_width, score};
      best_width = width;
      best_count = most;
    }
    std::size_t at = 0;
    while (at + best_width < kBins && below[at + best_width] - below[at] != best_count) ++at;
    best.log_gain = origin + (static_cast<float>(at) + 0.5f * static_cast<float>(best_width)) * kBin;
    return best;
  }

 private:
  static constexpr int kBins = 128;
  static constexpr float kBin = 0.04f;
  std::vector<int> bin_;
};

// One candidate per T of the grid.
std::vector<Consensus> over_the_grid(Columns& columns) {
  const std::size_t n = columns.size();
  const PerezCoefficients slope = perez_slopes(PerezQuantity::luminance);
  std::vector<Consensus> candidates;
  candidates.reserve(64);
  std::vector<float> work(4 * n);
  float *gradation = work.data(), *indicatrix = gradation + n, *next_gradation = indicatrix + n,
        *next_indicatrix = next_gradation + n;
  const float *per_cosine = columns.per_cosine(), *gamma = columns.gamma(), *cos2 = columns.cos2_gamma(),
              *log_y = columns.log_y();
  float* residual = columns.residual();
  Histogram histogram;
  for (const Run& run : kGrid) {
    const PerezCoefficients k0 = perez_coefficients(PerezQuantity::luminance, Turbidity{run.first});
    const auto b = static_cast<float>(k0.b), d = static_cast<float>(k0.d);
    const auto db = static_cast<float>(slope.b * run.step), dd = static_cast<float>(slope.d * run.step);
    for (std::size_t i = 0; i < n; ++i) {
      gradation[i] = fast_exp(b * per_cosine[i]);
      indicatrix[i] = fast_exp(d * gamma[i]);
      next_gradation[i] = fast_exp(db * per_cosine[i]);
      next_indicatrix[i] = fast_exp(dd * gamma[i]);
    }
    for (int j = 0; j < run.count; ++j) {
      const double t = run.first + j * run.step;
      const PerezCoefficients k = perez_coefficients(PerezQuantity::luminance, Turbidity{t});
      const auto a = static_cast<float>(k.a), c = static_cast<float>(k.c), e = static_cast<float>(k.e);
      for (std::size_t i = 0; i < n; ++i) {
        const float f = (1.0f + a * gradation[i]) * (1.0f + c * indicatrix[i] + e * cos2[i]);
        residual[i] = log_y[i] - fast_log(f);
        gradation[i] *= next_gradation[i];
        indicatrix[i] *= next_indicatrix[i];
      }
      candidates.push_back(histogram.fullest(residual, n, static_cast<float>(t)));
    }
  }
  return candidates;
}

// The best candidate, and the best of those that are not on the same hill.
std::array<Consensus, 2> two_best(const std::vector<Consensus>& all) {
  const auto best = std::ranges::max_element(all, {}, &Consensus::score);
  Consensus second;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const bool peak =
        (i == 0 || all[i].score >= all[i - 1].score) && (i + 1 == all.size() || all[i].score >= all[i + 1].score);
    const auto apart = std::abs(static_cast<std::ptrdiff_t>(i) - (best - all.begin()));
    if (peak && apart > 2 && all[i].score > second.score) second = all[i];
  }
  return {*best, second};
}

void residuals_and_slopes(Columns& columns, float t) {
  const PerezCoefficients k = perez_coefficients(PerezQuantity::luminance, Turbidity{static_cast<double>(t)});
  const PerezCoefficients s = perez_slopes(PerezQuantity::luminance);
  const auto a = static_cast<float>(k.a), b = static_cast<float>(k.b), c = static_cast<float>(k.c),
             d = static_cast<float>(k.d), e = static_cast<float>(k.e);
  const auto da = static_cast<float>(s.a), db = static_cast<float>(s.b), dc = static_cast<float>(s.c),
             dd = static_cast<float>(s.d), de = static_cast<float>(s.e);
  const float *per_cosine = columns.per_cosine(), *gamma = columns.gamma(), *cos2 = columns.cos2_gamma(),
              *log_y = columns.log_y();
  float *residual = columns.residual(), *slope = columns.slope();
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const float gradation = fast_exp(b * per_cosine[i]), indicatrix = fast_exp(d * gamma[i]);
    const float f1 = 1.0f + a * gradation, f2 = 1.0f + c * indicatrix + e * cos2[i];
    residual[i] = log_y[i] - fast_log(f1 * f2);
    slope[i] =
        (da + a * db * per_cosine[i]) * gradation / f1 + ((dc + c * dd * gamma[i]) * indicatrix + de * cos2[i]) / f2;
  }
}

// The half width that the residuals around `centre` ask for, and how well they then agree. Widths are half octaves,
// read off the floating point number itself.
struct Window {
  float half_width = 0.0f, score = 0.0f;
};
Window densest_window(const float* residual, std::size_t n, float centre, float narrowest, float widest) {
  constexpr int kFirst = (127 - 10) * 2;  // 2^-10
  constexpr std::size_t kCount = 20;
  std::array<int, kCount + 1> counts{};
  for (std::size_t i = 0; i < n; ++i) {
    const int half_octave = (std::bit_cast<int>(std::abs(residual[i] - centre)) >> 22) - kFirst;
    ++counts[static_cast<std::size_t>(std::clamp(half_octave, 0, static_cast<int>(kCount)))];
  }
  Window best{widest, -std::numeric_limits<float>::infinity()};
  int inside = 0;
  for (std::size_t j = 0; j < kCount; ++j) {
    inside += counts[j];
    const float edge = std::bit_cast<float>((kFirst + static_cast<int>(j) + 1) << 22);
    if (edge < narrowest) continue;
    if (edge > widest * 1.5f) break;
    const float score = agreement(static_cast<float>(inside), static_cast<float>(n), edge);
    if (score > best.score) best = {edge, score};
  }
  return best;
}

// Graduated non-convexity: Tukey's weights, whose reach shrinks from the candidate's window to the one the data ask
// for.
Consensus descend(Columns& columns, Consensus c, float narrowest, float widest) {
  constexpr int kRounds = 10;
  const auto lowest = static_cast<float>(kLowestTurbidity.value), highest = static_cast<float>(kHighestTurbidity.value);
  const float *residual = columns.residual(), *slope = columns.slope();
  for (int round = 0; round < kRounds; ++round) {
    residuals_and_slopes(columns, c.t);
    const float reach = 2.0f * c.window;
    const float per_reach2 = 1.0f / (reach * reach);
    float w_sum = 0.0f, ws = 0.0f, wr = 0.0f, wss = 0.0f, wsr = 0.0f;
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const float r = residual[i] - c.log_gain;
      const float u = std::max(0.0f, 1.0f - r * r * per_reach2);
      const float w = u * u;
      w_sum += w;
      ws += w * slope[i];
      wr += w * r;
      wss += w * slope[i] * slope[i];
      wsr += w * slope[i] * r;
    }
    if (!(w_sum > 0.0f)) break;
    const float information = wss - ws * ws / w_sum;
    if (!(information > 0.0f)) break;
    const float wanted = (wsr - ws * wr / w_sum) / information;
    const float largest_step = 0.4f * (c.t - 1.2f);  // ln F bends more the lower T
    const float step = std::clamp(std::clamp(wanted, -largest_step, largest_step), lowest - c.t, highest - c.t);
    c.log_gain += (wr - step * ws) / w_sum;
    c.t += step;
    for (std::size_t i = 0; i < columns.size(); ++i) columns.residual()[i] -= step * slope[i];
    const Window asked = densest_window(residual, columns.size(), c.log_gain, narrowest, widest);
    const bool settled = std::abs(step) < 1e-3f * c.t && asked.half_width >= 0.99f * c.window && round > 1;
    c.window = std::max(asked.half_width, 0.6f * c.window);
    c.score = asked.score;
    if (settled) break;
  }
  return c;
}

}  // namespace

Consensus find_consensus(std::span<const SkySample> samples, float narrowest, float widest) {
  constexpr std::size_t kMost = 32000;  // more say nothing new, and the histogram counts in sixteen bits
  Columns columns(samples.first(std::min(samples.size(), kMost)));
  Consensus best;
  for (const Consensus& start : two_best(over_the_grid(columns))) {
    if (!std::isfinite(start.score)) continue;
    const Consensus end = descend(columns, start, narrowest, widest);
    if (end.score > best.score) best = end;
  }
  return best;
}

}  // namespace kasumi
