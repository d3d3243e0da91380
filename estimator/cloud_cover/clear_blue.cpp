#include "estimator/cloud_cover/clear_blue.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/units.hpp"

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

struct Sample {
  double blueness;
  Terms terms;
};

double dot(const Terms& a, const Terms& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < kTerms; ++i) sum += a[i] * b[i];
  return sum;
}

double normal(double deviation, double variance, double cap = 1e9) {
  return std::exp(-0.5 * std::min(deviation * deviation / variance, cap)) / std::sqrt(2.0 * kPi * variance);
}

std::vector<Sample> samples_of(const PixelFeatures& sky, const cv::Mat1b& region, const cv::Mat1b& spoilt,
                               const cv::Mat1f& sun_deg, int wanted) {
  std::vector<cv::Point> places;
  for (int y = 0; y < region.rows; ++y)
    for (int x = 0; x < region.cols; ++x) {
      const cv::Vec3f& v = sky.rgb(y, x);
      if (region(y, x) && !spoilt(y, x) && std::max({v[0], v[1], v[2]}) > 0.08f) places.emplace_back(x, y);
    }
  std::vector<Sample> samples;
  const double step = std::max(1.0, static_cast<double>(places.size()) / wanted);
  for (double i = 0; i < static_cast<double>(places.size()); i += step) {
    const cv::Point& at = places[static_cast<std::size_t>(i)];
    samples.push_back(
        {sky.blueness(at), clear_terms(sky.zenith_deg(at), sun_deg.empty() ? 0.0f : sun_deg(at), !sun_deg.empty())});
  }
  return samples;
}

class Mixture {
 public:
  Mixture(const std::vector<Sample>& samples, const ClearBluePrior& options)
      : samples_(samples), options_(options), weight_(options.independent / static_cast<double>(samples.size())) {}

  void run(std::vector<double> clear) {
    for (int i = 0; i < 20; ++i) {
      fit_clear(clear);
      fit_cloud(clear);
      assign(clear);
    }
  }
  double score() const { return score_; }
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

  void fit_clear(const std::vector<double>& clear) {
    cv::Matx<double, kTerms, kTerms> normal_matrix = cv::Matx<double, kTerms, kTerms>::zeros();
    cv::Vec<double, kTerms> right;
    const double precision = weight_ / clear_variance_;
    for (std::size_t k = 0; k < samples_.size(); ++k)
      for (int i = 0; i < kTerms; ++i) {
        const double t = clear[k] * precision * samples_[k].terms[static_cast<std::size_t>(i)];
        right[i] += t * samples_[k].blueness;
        for (int j = 0; j <= i; ++j) normal_matrix(i, j) += t * samples_[k].terms[static_cast<std::size_t>(j)];
      }
    const Terms mean = expected();
    for (int i = 0; i < kTerms; ++i) {
      const double p = 1.0 / std::pow(spread(static_cast<std::size_t>(i)), 2);
      normal_matrix(i, i) += p;
      right[i] += p * mean[static_cast<std::size_t>(i)];
      for (int j = 0; j < i; ++j) normal_matrix(j, i) = normal_matrix(i, j);
    }
    const cv::Vec<double, kTerms> solved = normal_matrix.solve(right, cv::DECOMP_CHOLESKY);
    std::copy(solved.val, solved.val + kTerms, beta_.begin());
  }

  void fit_cloud(const std::vector<double>& clear) {
    double sum = 0.0, blueness = 0.0;
    for (std::size_t k = 0; k < samples_.size(); ++k) {
      sum += 1.0 - clear[k];
      blueness += (1.0 - clear[k]) * samples_[k].blueness;
    }
    const double data = weight_ / cloud_variance_, prior = 1.0 / std::pow(options_.cloud_sigma, 2);
    cloud_ = (data * blueness + prior * options_.cloud) / (data * sum + prior);
    // Scatter with a prior of a few samples.
    double clear_square = 0.0, cloud_square = 0.0, clear_sum = 0.0;
    for (std::size_t k = 0; k < samples_.size(); ++k) {
      const double off = samples_[k].blueness - clear_at(samples_[k]), from_cloud = samples_[k].blueness - cloud_;
      clear_square += clear[k] * off * off;
      cloud_square += (1.0 - clear[k]) * from_cloud * from_cloud;
      clear_sum += clear[k];
    }
    const auto variance = [&](double square, double count, double usual, double prior_count, double low, double high) {
      const double v = (weight_ * square + prior_count * usual * usual) / (weight_ * count + prior_count);
      return std::clamp(v, low * low, high * high);
    };
    clear_variance_ = variance(clear_square, clear_sum, kClearScatter, 4.0, 0.02, 0.10);
    cloud_variance_ = variance(cloud_square, sum, kCloudScatter, 8.0, 0.03, 0.07);
    share_ = std::clamp((weight_ * clear_sum + 1.0) / (options_.independent + 2.0), 0.005, 0.995);
  }

  void assign(std::vector<double>& clear) {
    score_ = 0.0;
    for (std::size_t k = 0; k < samples_.size(); ++k) {
      const double s = samples_[k].blueness, expected_clear = clear_at(samples_[k]);
      const double c = share_ * normal(s - expected_clear, clear_variance_, s > expected_clear ? 9.0 : 1e9);
      double w = (1.0 - share_) * (1.0 - kThin) * normal(s - cloud_, cloud_variance_);
      if (s > cloud_ && s < expected_clear) w += (1.0 - share_) * kThin / std::max(expected_clear - cloud_, 0.05);
      const double total = c + w + kOutlier;
      clear[k] = (c + 0.5 * kOutlier) / total;
      score_ += weight_ * std::log(total);
    }
    const Terms mean = expected();
    for (std::size_t i = 0; i < kTerms; ++i) score_ -= 0.5 * std::pow((beta_[i] - mean[i]) / spread(i), 2);
    score_ -= 0.5 * std::pow((cloud_ - options_.cloud) / options_.cloud_sigma, 2);
  }

  double clear_at(const Sample& sample) const { return std::max(dot(beta_, sample.terms), cloud_ + 0.02); }

  const std::vector<Sample>& samples_;
  const ClearBluePrior& options_;
  double weight_;
  Terms beta_{};
  double cloud_ = 0.06, clear_variance_ = 0.0025, cloud_variance_ = 0.0036, share_ = 0.5, score_ = 0.0;
};

}  // namespace

double ClearBlue::clear_at(double zenith_deg, double sun_deg) const {
  return dot(clear, clear_terms(zenith_deg, sun_deg, sun_known));
}

ClearBlue fit_clear_blue(const PixelFeatures& sky, const cv::Mat1b& region, const cv::Mat1f& sun_deg,
                         const ClearBluePrior& options) {
  ClearBlue best;
  best.sun_known = !sun_deg.empty();
  std::vector<Sample> samples = samples_of(sky, region, sky.partly, sun_deg, options.samples);
  constexpr std::size_t kFewest = 100;  // chosen: 20 samples for each of the five terms
  // Where blue is at full scale nearly everywhere, sky is at least as blue as it looks.
  if (samples.size() < kFewest) samples = samples_of(sky, region, sky.clipped, sun_deg, options.samples);
  if (samples.size() < kFewest) return best;
  best.found = true;
  double score = -1e30;
  // All clear, all cloud, and clear where bluer than so much.
  for (const double start : {-9.0, 9.0, 0.12, 0.22}) {
    std::vector<double> clear(samples.size());
    std::transform(samples.begin(), samples.end(), clear.begin(),
                   [&](const Sample& s) { return s.blueness > options.cloud - 0.06 + start ? 0.95 : 0.05; });
    Mixture mixture(samples, options);
    mixture.run(std::move(clear));
    if (mixture.score() <= score) continue;
    score = mixture.score();
    best.clear = mixture.clear();
    best.cloud = mixture.cloud();
    best.share = mixture.share();
  }
  std::vector<double> contrast;
  for (const Sample& s : samples) contrast.push_back(dot(best.clear, s.terms) - best.cloud);
  const auto high = contrast.begin() + static_cast<std::ptrdiff_t>(contrast.size() * 4 / 5);
  std::nth_element(contrast.begin(), high, contrast.end());
  best.contrast = *high;
  return best;
}

cv::Mat1f whiteness(const PixelFeatures& sky, const ClearBlue& blue, const cv::Mat1f& sun_deg) {
  // Below the lower contrast there is one kind of sky, above the higher one there are two.
  constexpr double kOneKind = 0.08, kTwoKinds = 0.14;
  const double one = std::clamp((kTwoKinds - blue.contrast) / (kTwoKinds - kOneKind), 0.0, 1.0);
  cv::Mat1f white(cv::Mat1f::zeros(sky.inside.size()));
  for (int y = 0; y < white.rows; ++y)
    for (int x = 0; x < white.cols; ++x) {
      if (!sky.inside(y, x)) continue;
      const double clear = blue.clear_at(sky.zenith_deg(y, x), sun_deg.empty() ? 0.0f : sun_deg(y, x));
      const double span = std::max(clear - blue.cloud, 0.06 + 0.14 * one) + 0.3 * one;
      white(y, x) = static_cast<float>(1.0 - (static_cast<double>(sky.blueness(y, x)) - blue.cloud) / span);
    }
  return white;
}

}  // namespace kasumi
