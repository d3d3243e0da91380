#include "estimator/cloud_cover/clear_blue.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/fast_log.hpp"
#include "base/units.hpp"
#include "estimator/nth_smallest.hpp"

namespace kasumi {

namespace {

constexpr int kTerms = 5;  // as many as clear_terms() makes
using Terms = std::array<double, kTerms>;

// 1, the growth of the air's mass towards the horizon (whole, and its first third), the sun's aureole (narrow, wide).
Terms clear_terms(double zenith_deg, double sun_deg, bool sun_known) {
  const double cosine = std::cos(from_degrees(zenith_deg).value);
  const double mass = (1.0 / std::sqrt(cosine * cosine + 0.02) - 1.0) / 6.0;
  if (!sun_known) return {1.0, mass, std::min(3.0 * mass, 1.0), 0.0, 0.0};
  return {1.0, mass, std::min(3.0 * mass, 1.0), std::exp(-sun_deg / 12.0), std::exp(-sun_deg / 35.0)};
}

// Expected coefficients and their spread; the first follows from the cloud's blueness.
constexpr Terms kExpected = {0.0, -0.05, 0.0, -0.15, -0.10};
constexpr Terms kSpread = {0.0, 0.15, 0.10, 0.15, 0.15};
constexpr double kClearScatter = 0.05, kCloudScatter = 0.05;
constexpr double kThin = 0.07;      // share of thin cloud, between both in colour, among cloud
constexpr double kOutlier = 0.013;  // density of neither

double dot(const Terms& a, const Terms& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < kTerms; ++i) sum += a[i] * b[i];
  return sum;
}

// Elements of the sky. What a least-squares fit sums over them lies side by side: products of two terms, row by row of
// the lower triangle, then of each with the blueness; filled up to whole vectors.
constexpr std::size_t kTriangle = kTerms * (kTerms + 1) / 2, kProducts = kTriangle + kTerms;
static_assert(kProducts % 4 == 0);
struct Samples {
  std::vector<float> blueness;
  std::vector<Terms> terms;
  std::vector<std::array<float, kProducts>> products;
  std::size_t size() const { return blueness.size(); }
  void add(float blue, const Terms& of_place) {
    blueness.push_back(blue);
    terms.push_back(of_place);
    auto& all = products.emplace_back();
    std::size_t k = 0;
    for (std::size_t i = 0; i < kTerms; ++i)
      for (std::size_t j = 0; j <= i; ++j) all[k++] = static_cast<float>(of_place[i] * of_place[j]);
    for (std::size_t i = 0; i < kTerms; ++i) all[k++] = static_cast<float>(of_place[i]) * blue;
  }
};

Samples samples_of(const PixelFeatures& sky, const cv::Mat1b& region, const cv::Mat1b& spoilt, const cv::Mat1f& sun_deg,
                   int wanted) {
  std::vector<cv::Point> places;
  for (int y = 0; y < region.rows; ++y) {
    const cv::Vec3f* rgb = sky.rgb[y];
    const auto *within = region[y], *without = spoilt[y];
    for (int x = 0; x < region.cols; ++x)
      if (within[x] && !without[x] && std::max({rgb[x][0], rgb[x][1], rgb[x][2]}) > 0.08f) places.emplace_back(x, y);
  }
  Samples samples;
  // Of a coarse picture every fourth will do: elements beside each other say the same.
  constexpr double kEnough = 400.0;
  const auto count = static_cast<double>(places.size());
  const double step = std::max(1.0, count / std::min<double>(wanted, std::max(kEnough, 0.25 * count)));
  for (double i = 0; i < static_cast<double>(places.size()); i += step) {
    const cv::Point& at = places[static_cast<std::size_t>(i)];
    samples.add(sky.blueness(at),
                clear_terms(sky.zenith_deg(at), sun_deg.empty() ? 0.0f : sun_deg(at), !sun_deg.empty()));
  }
  return samples;
}

class Mixture {
 public:
  Mixture(const Samples& samples, const ClearBluePrior& options)
      : samples_(samples),
        options_(options),
        weight_(options.independent / static_cast<double>(samples.size())),
        expected_(samples.size()),
        total_(samples.size()) {}

  // Until no sample's probability changes by what matters.
  void run(std::vector<float> clear) {
    constexpr int kMostRounds = 20;    // where two kinds of sky hardly differ it moves on for long
    constexpr float kSettled = 3e-5f;  // of a probability: no fraction's fourth digit sees it
    for (int i = 0; i < kMostRounds; ++i) {
      fit_clear(clear);
      fit_cloud(clear);
      if (assign(clear) < kSettled) break;
    }
    score_ = score();
  }
  double found_score() const { return score_; }
  const Terms& clear() const { return beta_; }
  double cloud() const { return cloud_; }
  double share() const { return share_; }

 private:
  Terms expected() const {
    Terms expected = kExpected;
    expected[0] = cloud_ + options_.zenith_contrast;
    return expected;
  }
  double spread(std::size_t i) const { return i == 0 ? options_.zenith_sigma : kSpread[i]; }

  void fit_clear(const std::vector<float>& clear) {
    constexpr std::size_t kBlock = 128;  // samples: single precision adds so many without loss
    std::array<double, kProducts> sums{};
    for (std::size_t from = 0; from < clear.size(); from += kBlock) {
      std::array<float, kProducts> part{};
      for (std::size_t k = from; k < std::min(from + kBlock, clear.size()); ++k)
        for (std::size_t q = 0; q < kProducts; ++q) part[q] += clear[k] * samples_.products[k][q];
      for (std::size_t q = 0; q < kProducts; ++q) sums[q] += static_cast<double>(part[q]);
    }
    cv::Matx<double, kTerms, kTerms> normal_matrix;
    cv::Vec<double, kTerms> right;
    const double precision = weight_ / clear_variance_;
    const Terms mean = expected();
    std::size_t q = 0;
    for (int i = 0; i < kTerms; ++i)
      for (int j = 0; j <= i; ++j) normal_matrix(i, j) = normal_matrix(j, i) = precision * sums[q++];
    for (int i = 0; i < kTerms; ++i) {
      const double p = 1.0 / std::pow(spread(static_cast<std::size_t>(i)), 2);
      normal_matrix(i, i) += p;
      right[i] = precision * sums[q++] + p * mean[static_cast<std::size_t>(i)];
    }
    const cv::Vec<double, kTerms> solved = normal_matrix.solve(right, cv::DECOMP_CHOLESKY);
    std::copy(solved.val, solved.val + kTerms, beta_.begin());
  }

  void fit_cloud(const std::vector<float>& clear) {
    double sum = 0.0, blueness = 0.0;
    for (std::size_t k = 0; k < clear.size(); ++k) {
      const double cloudy = 1.0 - static_cast<double>(clear[k]);
      sum += cloudy;
      blueness += cloudy * static_cast<double>(samples_.blueness[k]);
    }
    const double data = weight_ / cloud_variance_, prior = 1.0 / std::pow(options_.cloud_sigma, 2);
    cloud_ = (data * blueness + prior * options_.cloud) / (data * sum + prior);
    for (std::size_t k = 0; k < clear.size(); ++k)
      expected_[k] = static_cast<float>(std::max(dot(beta_, samples_.terms[k]), cloud_ + 0.02));
    // Scatter with a prior of a few samples.
    double clear_square = 0.0, cloud_square = 0.0, clear_sum = 0.0;
    for (std::size_t k = 0; k < clear.size(); ++k) {
      const double off = static_cast<double>(samples_.blueness[k] - expected_[k]),
                   from_cloud = static_cast<double>(samples_.blueness[k]) - cloud_,
                   probability = static_cast<double>(clear[k]);
      clear_square += probability * off * off;
      cloud_square += (1.0 - probability) * from_cloud * from_cloud;
      clear_sum += probability;
    }
    const auto variance = [&](double square, double count, double usual, double prior_count, double low, double high) {
      const double v = (weight_ * square + prior_count * usual * usual) / (weight_ * count + prior_count);
      return std::clamp(v, low * low, high * high);
    };
    clear_variance_ = variance(clear_square, clear_sum, kClearScatter, 4.0, 0.02, 0.10);
    cloud_variance_ = variance(cloud_square, sum, kCloudScatter, 8.0, 0.03, 0.07);
    share_ = std::clamp((weight_ * clear_sum + 1.0) / (options_.independent + 2.0), 0.005, 0.995);
  }

  // The largest change of a probability.
  float assign(std::vector<float>& clear) {
    const auto peak = [](double share, double variance) {
      return static_cast<float>(share / std::sqrt(2.0 * kPi * variance));
    };
    constexpr float kNever = 80.0f;  // half of a square deviation: beyond, a density is nothing beside kOutlier
    const float clear_peak = peak(share_, clear_variance_),
                cloud_peak = peak((1.0 - share_) * (1.0 - kThin), cloud_variance_),
                thin = static_cast<float>((1.0 - share_) * kThin), cloud = static_cast<float>(cloud_),
                by_clear = static_cast<float>(0.5 / clear_variance_),
                by_cloud = static_cast<float>(0.5 / cloud_variance_), outlier = static_cast<float>(kOutlier);
    const float* blueness = samples_.blueness.data();
    const float* expected = expected_.data();
    float *total = total_.data(), *probability = clear.data();
    std::array<float, 4> change{};  // as many as a vector has
    const std::size_t count = clear.size();
    for (std::size_t k = 0; k < count; ++k) {
      const float s = blueness[k], e = expected[k], off = s - e, from_cloud = s - cloud;
      const float clear_off = std::min(by_clear * off * off, off > 0.0f ? 4.5f : kNever),
                  cloud_off = std::min(by_cloud * from_cloud * from_cloud, kNever);
      const float between = (from_cloud > 0.0f) & (off < 0.0f) ? thin / std::max(e - cloud, 0.05f) : 0.0f;
      const float c = clear_peak * fast_exp(-clear_off);
      total[k] = c + cloud_peak * fast_exp(-cloud_off) + between + outlier;
      expected_[k] = (c + 0.5f * outlier) / total[k];
    }
    for (std::size_t k = 0; k < count; ++k) {
      change[k % 4] = std::max(change[k % 4], std::abs(expected[k] - probability[k]));
      probability[k] = expected[k];
    }
    return *std::max_element(change.begin(), change.end());
  }

  double score() const {
    double score = 0.0;
    for (const float total : total_) score += weight_ * std::log(static_cast<double>(total));
    const Terms mean = expected();
    for (std::size_t i = 0; i < kTerms; ++i) score -= 0.5 * std::pow((beta_[i] - mean[i]) / spread(i), 2);
    return score - 0.5 * std::pow((cloud_ - options_.cloud) / options_.cloud_sigma, 2);
  }

  const Samples& samples_;
  const ClearBluePrior& options_;
  double weight_;
  Terms beta_{};
  double cloud_ = 0.06, clear_variance_ = 0.0025, cloud_variance_ = 0.0036, share_ = 0.5, score_ = 0.0;
  std::vector<float> expected_;  // blueness of clear sky; then the probability of it
  std::vector<float> total_;     // density of the mixture
};

}  // namespace

double ClearBlue::clear_at(double zenith_deg, double sun_deg) const {
  return dot(clear, clear_terms(zenith_deg, sun_deg, sun_known));
}

ClearBlue fit_clear_blue(const PixelFeatures& sky, const cv::Mat1b& region, const cv::Mat1f& sun_deg,
                         const ClearBluePrior& options) {
  ClearBlue best;
  best.sun_known = !sun_deg.empty();
  Samples samples = samples_of(sky, region, sky.partly, sun_deg, options.samples);
  constexpr std::size_t kFewest = 100;  // chosen: 20 samples for each of the five terms
  // Where blue is at full scale nearly everywhere, sky is at least as blue as it looks.
  if (samples.size() < kFewest) samples = samples_of(sky, region, sky.clipped, sun_deg, options.samples);
  if (samples.size() < kFewest) return best;
  best.found = true;
  double score = -1e30;
  // All clear, all cloud, and clear where bluer than so much.
  for (const double start : {-9.0, 9.0, 0.12, 0.22}) {
    std::vector<float> clear(samples.size());
    std::ranges::transform(samples.blueness, clear.begin(), [&](float blueness) {
      return static_cast<double>(blueness) > options.cloud - 0.06 + start ? 0.95f : 0.05f;
    });
    Mixture mixture(samples, options);
    mixture.run(std::move(clear));
    if (mixture.found_score() <= score) continue;
    score = mixture.found_score();
    best.clear = mixture.clear();
    best.cloud = mixture.cloud();
    best.share = mixture.share();
  }
  std::vector<float> contrast;
  for (const Terms& terms : samples.terms) contrast.push_back(static_cast<float>(dot(best.clear, terms) - best.cloud));
  best.contrast = static_cast<double>(nth_smallest(contrast, contrast.size() * 4 / 5));
  return best;
}

cv::Mat1f whiteness(const PixelFeatures& sky, const ClearBlue& blue, const cv::Mat1f& sun_deg) {
  // Below the lower contrast there is one kind of sky, above the higher one there are two.
  constexpr double kOneKind = 0.08, kTwoKinds = 0.14;
  const double one = std::clamp((kTwoKinds - blue.contrast) / (kTwoKinds - kOneKind), 0.0, 1.0);
  const auto least = static_cast<float>(0.06 + 0.14 * one), more = static_cast<float>(0.3 * one),
             cloud = static_cast<float>(blue.cloud);
  std::array<float, kTerms> factors{};
  for (std::size_t i = 0; i < kTerms; ++i) factors[i] = static_cast<float>(blue.clear[i]);
  cv::Mat1f white(sky.inside.size());
  const std::vector<float> far(static_cast<std::size_t>(white.cols), 1e3f);  // from the sun, where that is not known
  for (int y = 0; y < white.rows; ++y) {
    const auto* inside = sky.inside[y];
    const cv::Vec3f* direction = sky.direction[y];
    const float *blueness = sky.blueness[y], *from_sun = sun_deg.empty() ? far.data() : sun_deg[y];
    float* here = white[y];
    for (int x = 0; x < white.cols; ++x) {
      // As clear_terms() has it.
      const float cosine = direction[x][2], mass = (1.0f / std::sqrt(cosine * cosine + 0.02f) - 1.0f) / 6.0f,
                  off = std::min(from_sun[x], 900.0f);
      const float clear = factors[0] + factors[1] * mass + factors[2] * std::min(3.0f * mass, 1.0f) +
                          factors[3] * fast_exp(off * (-1.0f / 12.0f)) + factors[4] * fast_exp(off * (-1.0f / 35.0f));
      const float span = std::max(clear - cloud, least) + more;
      const float white_here = 1.0f - (blueness[x] - cloud) / span;  // not under a condition: no vector waits for one
      here[x] = inside[x] ? white_here : 0.0f;
    }
  }
  return white;
}

}  // namespace kasumi
