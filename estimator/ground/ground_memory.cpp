#include "estimator/ground/ground_memory.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace kasumi {
namespace {

constexpr double kDarkest = 0.01, kPalest = 1.0;  // reflectance
constexpr double kPriorSigma = 0.5;               // of its logarithm
constexpr double kModelSigma = 0.06;              // of sun and sky as computed, of the ground's gloss
constexpr double kMostSuns = 200.0;               // sun over sky: more does not occur

// Before anything is seen. Most ground that a shadow could fall on lies in the sun; the edge of a shadow is narrow.
constexpr double kInSun = 0.8, kInShade = 0.17, kAtEdge = 0.03;
constexpr double kSomethingElse = 1e-3;  // density of a brightness that no ground explains: people, snow, a puddle

constexpr double kLately_s = 15.0;  // what is older says nothing about now
// Chosen: the sun moves by a quarter of a degree in it, so more often shows the same.
constexpr double kLearnEvery_s = 60.0;
constexpr double kIndependent_s = 600.0;    // sights so far apart err independently of each other
constexpr double kForget_s = 14 * 86400.0;  // seasons, mowing, new gravel
constexpr double kDrift = 0.02;             // moved to each neighbouring step for an independent sight: rain, gloss

double normal_density(double off, double sigma) {
  if (std::abs(off) > 6.0 * sigma) return 0.0;
  return std::exp(-0.5 * off * off / (sigma * sigma)) / (sigma * 2.5066282746310002);
}

template <class Range>
void normalise(Range& shares) {
  const float sum = std::accumulate(shares.begin(), shares.end(), 0.0f);
  for (float& share : shares) share /= sum;
}

}  // namespace

float GroundMemory::reflectance_of(int step) {
  static const Shares table = [] {
    Shares made{};
    for (int i = 0; i < kSteps; ++i)
      made[static_cast<std::size_t>(i)] =
          static_cast<float>(kDarkest * std::pow(kPalest / kDarkest, (i + 0.5) / kSteps));
    return made;
  }();
  return table[static_cast<std::size_t>(step)];
}

GroundMemory::GroundMemory(std::span<const float> reflectance)
    : places_(reflectance.size()), guesses_(reflectance.size()) {
  for (std::size_t i = 0; i < places_.size(); ++i) {
    Shares& prior = places_[i].prior;
    const double middle = std::log(std::clamp(static_cast<double>(reflectance[i]), kDarkest, kPalest));
    for (int step = 0; step < kSteps; ++step)
      prior[static_cast<std::size_t>(step)] = static_cast<float>(
          1e-4 + normal_density(std::log(static_cast<double>(reflectance_of(step))) - middle, kPriorSigma));
    normalise(prior);
    places_[i].now = prior;
  }
}

// How well each reflectance explains a sight, by ground in the sun, in the shade or at a shadow's edge, and what these
// say of the sun together.
GroundMemory::Likelihood GroundMemory::explain(const Shares& reflectance, const GroundSight& sight) const {
  const double sun = sight.sun, sky = std::max(static_cast<double>(sight.sky), sun / kMostSuns);
  const double sigma = std::hypot(kModelSigma, static_cast<double>(sight.sigma));
  const double contrast = std::log((sun + sky) / sky), wide = std::max(contrast, sigma);
  const double first =
      std::log(std::max(static_cast<double>(sight.radiance), 1e-9) / (static_cast<double>(reflectance_of(0)) * sky));
  static const double kStep = std::log(kPalest / kDarkest) / kSteps;
  Likelihood found;
  double sum = 0.0, mean = 0.0, square = 0.0;
  for (int step = 0; step < kSteps; ++step) {
    const auto at = static_cast<std::size_t>(step);
    const double rho = reflectance_of(step), above_shade = first - step * kStep;
    const double lit = kInSun * normal_density(above_shade - contrast, sigma);
    const double shaded = kInShade * normal_density(above_shade, sigma);
    const bool between = above_shade > 0.0 && above_shade < contrast;
    const double edge = between ? kAtEdge / wide : 0.0;
    const double share =
        sun > 0.0 ? std::clamp((static_cast<double>(sight.radiance) / rho - sky) / sun, 0.0, 1.0) : 1.0;
    const double belief = static_cast<double>(reflectance[at]);
    found.of_step[at] = static_cast<float>(lit + shaded + edge + kSomethingElse);
    sum += belief * (lit + shaded + edge);
    mean += belief * (lit + edge * share);
    square += belief * (lit + edge * share * share);
  }
  if (sum < kSomethingElse) return {found.of_step, {0.5f, 0.5f}};  // no ground looks like that
  mean /= sum;
  found.guess = {static_cast<float>(mean), static_cast<float>(std::sqrt(std::max(square / sum - mean * mean, 0.0)))};
  return found;
}

void GroundMemory::learn(Place& place, const Shares& likelihood, double weight, double forgotten) {
  Shares& now = place.now;
  for (std::size_t i = 0; i < now.size(); ++i) now[i] *= std::pow(likelihood[i], static_cast<float>(weight));
  normalise(now);
  const auto moved = static_cast<float>(kDrift * weight), lost = static_cast<float>(forgotten);
  const Shares before = now;
  for (std::size_t i = 0; i < now.size(); ++i) {
    const float left = before[i > 0 ? i - 1 : 0], right = before[std::min(i + 1, now.size() - 1)];
    now[i] = (1.0f - lost) * (before[i] + moved * (left + right - 2.0f * before[i])) + lost * place.prior[i];
  }
}

void GroundMemory::see(std::span<const GroundSight> sights, double at_s) {
  const bool anew = !seen_at_s_ || std::abs(at_s - *seen_at_s_) > kLately_s;
  seen_at_s_ = at_s;
  const double since_s = learned_at_s_ ? std::abs(at_s - *learned_at_s_) : kLearnEvery_s;
  const bool learning = since_s >= kLearnEvery_s;
  if (learning) {
    learned_at_s_ = at_s;
    ++lessons_;
  }
  for (std::size_t i = 0; i < places_.size(); ++i) {
    Place& place = places_[i];
    GroundSight sight = sights[i];
    if (anew) place.seen = 0;
    if (sight.sigma <= 0.0f || sight.sun + sight.sky <= 0.0f) {
      place.seen = 0;
      continue;  // the guess stays
    }
    const float full = sight.sun + sight.sky;
    if (place.seen == kLately) {
      std::rotate(place.lately.begin(), place.lately.begin() + 1, place.lately.end());
      --place.seen;
    }
    place.lately[static_cast<std::size_t>(place.seen++)] = sight.radiance / full;
    auto sorted = place.lately;
    const auto middle = sorted.begin() + (place.seen - 1) / 2;
    std::nth_element(sorted.begin(), middle, sorted.begin() + place.seen);
    sight.radiance = *middle * full;
    const Likelihood found = explain(place.now, sight);
    guesses_[i] = found.guess;
    if (learning)
      learn(place, found.of_step, std::min(since_s / kIndependent_s, 1.0), std::min(since_s / kForget_s, 1.0));
  }
}

double GroundMemory::reflectance(std::size_t place) const {
  float sum = 0.0f;
  for (int step = 0; step < kSteps; ++step)
    if ((sum += places_[place].now[static_cast<std::size_t>(step)]) >= 0.5f)
      return static_cast<double>(reflectance_of(step));
  return kPalest;
}

std::vector<std::uint8_t> GroundMemory::learnt() const {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(places_.size() * kLearntBytes);
  for (const Place& place : places_) {
    const float most = *std::ranges::max_element(place.now);
    for (const float share : place.now)
      bytes.push_back(static_cast<std::uint8_t>(std::lround(255.0f * std::sqrt(share / most))));
  }
  return bytes;
}

bool GroundMemory::resume(std::span<const std::uint8_t> learnt, double since_s) {
  if (learnt.size() != places_.size() * kLearntBytes) return false;
  std::vector<Shares> shares(places_.size());
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const auto bytes = learnt.subspan(i * kLearntBytes, kLearntBytes);
    if (std::ranges::find(bytes, std::uint8_t{255}) == bytes.end()) return false;
    for (std::size_t step = 0; step < kLearntBytes; ++step) {
      const float root = static_cast<float>(bytes[step]) / 255.0f;
      shares[i][step] = root * root;
    }
    normalise(shares[i]);
  }
  const auto lost = static_cast<float>(std::clamp(since_s / kForget_s, 0.0, 1.0));
  for (std::size_t i = 0; i < places_.size(); ++i)
    for (std::size_t step = 0; step < kLearntBytes; ++step)
      places_[i].now[step] = (1.0f - lost) * shares[i][step] + lost * places_[i].prior[step];
  return true;
}

}  // namespace kasumi
