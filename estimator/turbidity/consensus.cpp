// The hot path: single precision and branch-free loops, so that compilers vectorise them.
#include "estimator/turbidity/consensus.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <vector>

#include "base/fast_log.hpp"
#include "estimator/sky/preetham.hpp"

namespace kasumi {

namespace {

// Coarse where T hardly changes the sky: steps of about 0.03 in ln F. Each run of equal steps needs only two
// exponentials per sample, since B and D are linear in T.
struct Run {
  double first, step;
  int count;
};
// Fine where the sky changes fast with T; 55 in all, of which the best is refined.
constexpr std::array<Run, 6> kGrid{
    {{1.70, 0.02, 16}, {2.02, 0.04, 12}, {2.50, 0.10, 8}, {3.30, 0.25, 8}, {5.30, 0.80, 5}, {9.30, 2.14, 6}}};

// Background density of samples that fit nothing: they lie anywhere in this range of ln Y.
constexpr float kBackgroundRange = 3.0f;

// The samples compared with the skies of one model.
class Skies {
 public:
  Skies(std::span<const LuminanceSample> samples, Turbidity lowest, Turbidity highest)
      : n_(samples.size()),
        lowest_(static_cast<float>(lowest.value)),
        highest_(static_cast<float>(highest.value)),
        log_y_(n_),
        residual_(n_),
        slope_(n_) {
    for (std::size_t i = 0; i < n_; ++i) log_y_[i] = samples[i].log_luminance;
  }
  virtual ~Skies() = default;
  std::size_t size() const { return n_; }
  float lowest() const { return lowest_; }
  float highest() const { return highest_; }
  float* residual() { return residual_.data(); }        // ln Y - ln F
  const float* slope() const { return slope_.data(); }  // d ln F / dT

  // Fills residual() for each T of the grid in turn, and calls use(T).
  virtual void over_the_grid(const std::function<void(float)>& use) = 0;
  // Fills residual() and slope().
  virtual void evaluate(float t) = 0;

 protected:
  std::size_t n_;
  float lowest_, highest_;
  std::vector<float> log_y_, residual_, slope_;
};

// Log likelihood that n of all samples lie in a window of this half width and the rest anywhere: rewards many inliers
// and narrow windows, which lets the data choose the window.
inline float agreement(float n, float all, float half_width) {
  const float rest = all - n;
  const float inside = n > 0.0f ? n * fast_log(n / (all * 2.0f * half_width)) : 0.0f;
  const float outside = rest > 0.0f ? rest * fast_log(rest / (all * kBackgroundRange)) : 0.0f;
  return inside + outside;
}

// The fullest window among the residuals, for several widths at once. Counts have sixteen bits, because eight of them
// fit a vector register.
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
  static constexpr int kBins = 128;     // 5 of ln Y in steps of 4 %
  static constexpr float kBin = 0.04f;  // of ln Y, see kBins
  std::vector<int> bin_;
};

// What Perez' distribution needs of the samples for one T after another in equal steps, each T's column by column.
// Pointers that share no memory: else compilers look at one sample at a time.
struct PerezColumns {
  std::size_t n;
  const float* __restrict log_y, * __restrict per_cosine, * __restrict gamma, * __restrict cos2_gamma;
};
struct PerezWork {
  float* __restrict gradation, * __restrict indicatrix, * __restrict next_gradation, * __restrict next_indicatrix;
};

inline void exponentials(std::size_t n, float factor, const float* __restrict from, float* __restrict to) {
  for (std::size_t i = 0; i < n; ++i) to[i] = fast_exp(factor * from[i]);
}

// Residuals at this T; the exponentials then are those of the next.
inline void residuals_and_on(float a, float c, float e, const PerezColumns& at, const PerezWork& work,
                             float* __restrict residual) {
  const float* __restrict log_y = at.log_y, * __restrict cos2 = at.cos2_gamma;
  const float* __restrict next_gradation = work.next_gradation, * __restrict next_indicatrix = work.next_indicatrix;
  float* __restrict gradation = work.gradation, * __restrict indicatrix = work.indicatrix;
  for (std::size_t i = 0; i < at.n; ++i) {
    const float f = (1.0f + a * gradation[i]) * (1.0f + c * indicatrix[i] + e * cos2[i]);
    residual[i] = log_y[i] - fast_log(f);
    gradation[i] *= next_gradation[i];
    indicatrix[i] *= next_indicatrix[i];
  }
}

class PerezSkies final : public Skies {
 public:
  explicit PerezSkies(std::span<const LuminanceSample> samples)
      : Skies(samples, kLowestTurbidity, kHighestTurbidity), per_cosine_(n_), gamma_(n_), cos2_gamma_(n_) {
    for (std::size_t i = 0; i < n_; ++i) {
      const LuminanceSample& s = samples[i];
      const float cosine = std::cos(s.sun_distance);
      per_cosine_[i] = 1.0f / std::max(static_cast<float>(kSmallestCosine), std::cos(s.zenith));
      gamma_[i] = s.sun_distance;
      cos2_gamma_[i] = cosine * cosine;
    }
  }

  void over_the_grid(const std::function<void(float)>& use) override {
    const std::size_t n = n_;
    const PerezCoefficients slope = perez_slopes(PerezQuantity::luminance);
    std::vector<float> space(4 * n);
    const PerezWork work{space.data(), space.data() + n, space.data() + 2 * n, space.data() + 3 * n};
    const PerezColumns at{n, log_y_.data(), per_cosine_.data(), gamma_.data(), cos2_gamma_.data()};
    for (const Run& run : kGrid) {
      const PerezCoefficients k0 = perez_coefficients(PerezQuantity::luminance, Turbidity{run.first});
      exponentials(n, static_cast<float>(k0.b), at.per_cosine, work.gradation);
      exponentials(n, static_cast<float>(k0.d), at.gamma, work.indicatrix);
      exponentials(n, static_cast<float>(slope.b * run.step), at.per_cosine, work.next_gradation);
      exponentials(n, static_cast<float>(slope.d * run.step), at.gamma, work.next_indicatrix);
      for (int j = 0; j < run.count; ++j) {
        const double t = run.first + j * run.step;
        const PerezCoefficients k = perez_coefficients(PerezQuantity::luminance, Turbidity{t});
        residuals_and_on(static_cast<float>(k.a), static_cast<float>(k.c), static_cast<float>(k.e), at, work,
                         residual_.data());
        use(static_cast<float>(t));
      }
    }
  }

  void evaluate(float t) override {
    const PerezCoefficients k = perez_coefficients(PerezQuantity::luminance, Turbidity{static_cast<double>(t)});
    const PerezCoefficients s = perez_slopes(PerezQuantity::luminance);
    const auto a = static_cast<float>(k.a), b = static_cast<float>(k.b), c = static_cast<float>(k.c),
               d = static_cast<float>(k.d), e = static_cast<float>(k.e);
    const auto da = static_cast<float>(s.a), db = static_cast<float>(s.b), dc = static_cast<float>(s.c),
               dd = static_cast<float>(s.d), de = static_cast<float>(s.e);
    const float *per_cosine = per_cosine_.data(), *gamma = gamma_.data(), *cos2 = cos2_gamma_.data(),
                *log_y = log_y_.data();
    float *residual = residual_.data(), *slope = slope_.data();
    for (std::size_t i = 0; i < n_; ++i) {
      const float gradation = fast_exp(b * per_cosine[i]), indicatrix = fast_exp(d * gamma[i]);
      const float f1 = 1.0f + a * gradation, f2 = 1.0f + c * indicatrix + e * cos2[i];
      residual[i] = log_y[i] - fast_log(f1 * f2);
      slope[i] =
          (da + a * db * per_cosine[i]) * gradation / f1 + ((dc + c * dd * gamma[i]) * indicatrix + de * cos2[i]) / f2;
    }
  }

 private:
  std::vector<float> per_cosine_, gamma_, cos2_gamma_;
};

class DomeSkies final : public Skies {
 public:
  DomeSkies(std::span<const LuminanceSample> samples, const DomeLog& dome)
      : Skies(samples, dome.lowest(), dome.highest()), dome_(dome), columns_(DomeLog::kNodes * n_) {
    for (std::size_t i = 0; i < n_; ++i) {
      const auto nodes = dome.at(std::cos(double{samples[i].zenith}), std::cos(double{samples[i].sun_distance}));
      for (std::size_t k = 0; k < DomeLog::kNodes; ++k) columns_[k * n_ + i] = nodes[k];
    }
  }

  // Steps of less than .05 in ln F, except next to the sun.
  void over_the_grid(const std::function<void(float)>& use) override {
    constexpr int kSteps = 32;  // of ln T, see above
    for (int i = 0; i <= kSteps; ++i) {
      const double t = dome_.lowest().value *
                       std::pow(dome_.highest().value / dome_.lowest().value, static_cast<double>(i) / kSteps);
      evaluate(static_cast<float>(t));
      use(static_cast<float>(t));
    }
  }

  void evaluate(float t) override {
    const auto between = dome_.between(Turbidity{static_cast<double>(t)});
    const float* column = columns_.data() + between.first * n_;
    std::ranges::copy(log_y_, residual_.begin());
    std::ranges::fill(slope_, 0.0f);
    for (std::size_t k = 0; k < 4; ++k, column += n_) {
      const auto value = static_cast<float>(between.value[k]), slope = static_cast<float>(between.slope[k]);
      for (std::size_t i = 0; i < n_; ++i) {
        residual_[i] -= value * column[i];
        slope_[i] += slope * column[i];
      }
    }
  }

 private:
  const DomeLog& dome_;
  std::vector<float> columns_;  // node by node
};

// One candidate for each T of the grid.
std::vector<Consensus> candidates_of(Skies& skies) {
  std::vector<Consensus> candidates;
  candidates.reserve(64);
  Histogram histogram;
  skies.over_the_grid([&](float t) { candidates.push_back(histogram.fullest(skies.residual(), skies.size(), t)); });
  return candidates;
}

// The best candidate, and the best of those not around the same maximum.
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

// The half width that fits the residuals around `centre`, and how well they then agree. Widths are half octaves, taken
// from the bits of the floating point number.
struct Window {
  float half_width = 0.0f, score = 0.0f;
};
Window densest_window(const float* residual, std::size_t n, float centre, float narrowest, float widest) {
  constexpr int kFirst = (127 - 10) * 2;  // 2^-10
  constexpr std::size_t kCount = 20;      // half octaves: from 2^-10 to 1
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

// Graduated non-convexity: Tukey's weights, whose width shrinks from the candidate's window to the one that fits the
// data.
Consensus descend(Skies& skies, Consensus c, float narrowest, float widest) {
  constexpr int kRounds = 10;  // of the shrinking window
  const float lowest = skies.lowest(), highest = skies.highest();
  float* residual = skies.residual();
  const float* slope = skies.slope();
  for (int round = 0; round < kRounds; ++round) {
    skies.evaluate(c.t);
    const float reach = 2.0f * c.window;
    const float per_reach2 = 1.0f / (reach * reach);
    float w_sum = 0.0f, ws = 0.0f, wr = 0.0f, wss = 0.0f, wsr = 0.0f;
    for (std::size_t i = 0; i < skies.size(); ++i) {
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
    const float largest_step = 0.4f * (c.t - (lowest - 0.5f));  // ln F is more curved at low T
    const float step = std::clamp(std::clamp(wanted, -largest_step, largest_step), lowest - c.t, highest - c.t);
    c.log_gain += (wr - step * ws) / w_sum;
    c.t += step;
    for (std::size_t i = 0; i < skies.size(); ++i) residual[i] -= step * slope[i];
    const Window asked = densest_window(residual, skies.size(), c.log_gain, narrowest, widest);
    const bool settled = std::abs(step) < 1e-3f * c.t && asked.half_width >= 0.99f * c.window && round > 1;
    c.window = std::max(asked.half_width, 0.6f * c.window);
    c.score = asked.score;
    if (settled) break;
  }
  return c;
}

}  // namespace

Consensus find_consensus(std::span<const LuminanceSample> samples, float narrowest, float widest,
                         const FittedSky& sky) {
  constexpr std::size_t kMost = 32000;  // more add no information, and the histogram counts in sixteen bits
  samples = samples.first(std::min(samples.size(), kMost));
  std::unique_ptr<Skies> skies;
  if (const DomeLog* dome = sky.dome())
    skies = std::make_unique<DomeSkies>(samples, *dome);
  else
    skies = std::make_unique<PerezSkies>(samples);
  Consensus best;
  for (const Consensus& start : two_best(candidates_of(*skies))) {
    if (!std::isfinite(start.score)) continue;
    const Consensus end = descend(*skies, start, narrowest, widest);
    if (end.score > best.score) best = end;
  }
  return best;
}

}  // namespace kasumi
