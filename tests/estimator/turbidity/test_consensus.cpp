#include <cmath>

#include <gtest/gtest.h>

#include "estimator/turbidity/consensus.hpp"
#include "tests/estimator/turbidity/synthetic_sky.hpp"

namespace kasumi {
namespace {

// What clouds have in common is loose: a fifth of the sky that agrees closely counts for more than two fifths that agree
// loosely, the rest being anywhere.
TEST(Consensus, IsOfTheClearSkyWhereCloudsAgreeLoosely) {
  constexpr double kClear = 3.0, kClouds = 9.0, kNoise = 0.005;
  constexpr std::uint64_t kSamples = 1000;
  const double sun_zenith = from_degrees(58.4).value;
  const Direction sun = direction_from({sun_zenith}, {1.0});
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    std::vector<LuminanceSample> samples;
    for (std::uint64_t i = 0; i < kSamples; ++i) {
      const auto chance = [&](std::uint64_t j) { return test::hashed_uniform(100 * seed + j, i); };
      const Direction d = direction_from({std::acos(1.0 - 0.826 * chance(1))}, {2.0 * kPi * chance(2)});
      const double zenith = zenith_angle(d).value, gamma = angle_between(d, sun).value;
      const auto log_y = [&](double t) { return std::log(test::preetham_yxy(t, zenith, sun_zenith, gamma).x); };
      double light = log_y(kClear) + kNoise * test::hashed_normal(100 * seed + 3, i);
      if (i >= kSamples / 5) light = log_y(kClouds) + 0.28 * (chance(4) - 0.5);
      if (i >= 3 * kSamples / 5) light = log_y(kClear) + 4.0 * (chance(5) - 0.5);
      samples.push_back({static_cast<float>(zenith), static_cast<float>(gamma), static_cast<float>(light),
                         static_cast<float>(kNoise), 0.0f});
    }
    EXPECT_NEAR(find_consensus(samples, 0.0125f, 0.2f).t, kClear, 0.1) << seed;
  }
}

}  // namespace
}  // namespace kasumi
