#include <cmath>

#include <gtest/gtest.h>

#include "tests/estimator/turbidity/cramer_rao.hpp"
#include "tests/estimator/turbidity/synthetic_sky.hpp"

namespace kasumi {
namespace {

std::vector<LuminanceSample> even_samples(double sigma) {
  std::vector<LuminanceSample> samples;
  const Direction sun = direction_from(from_degrees(58.4), {0.0});
  for (int i = 0; i < 100; ++i) {
    const Direction d = direction_from({1.3 * test::hashed_uniform(1, static_cast<std::uint64_t>(i))},
                                       {6.28 * test::hashed_uniform(2, static_cast<std::uint64_t>(i))});
    samples.push_back({static_cast<float>(zenith_angle(d).value), static_cast<float>(angle_between(d, sun).value), 0.0f,
                       static_cast<float>(sigma), static_cast<float>(0.5 * sigma)});
  }
  return samples;
}

// d ln F / dT by central differences of the independent sky implementation, projected on what a free gain cannot
// absorb.
TEST(CramerRao, IsTheInverseRootOfTheProjectedInformation) {
  const auto samples = even_samples(0.01);
  for (const double t : {2.0, 5.0, 9.0}) {
    std::vector<double> slopes;
    double mean = 0.0;
    for (const LuminanceSample& s : samples) {
      const auto log_y = [&](double at) {
        return std::log(
            test::preetham_yxy(at, static_cast<double>(s.zenith), 1.0, static_cast<double>(s.sun_distance)).x);
      };
      slopes.push_back((log_y(t + 1e-5) - log_y(t - 1e-5)) / 2e-5);
      mean += slopes.back() / static_cast<double>(samples.size());
    }
    double information = 0.0;
    for (const double s : slopes) information += (s - mean) * (s - mean) / 1e-4;
    EXPECT_NEAR(cramer_rao_sigma(samples, Turbidity{t}) * std::sqrt(information), 1.0, 1e-5);
    EXPECT_NEAR(cramer_rao_sigma(samples, Turbidity{t}, true) * std::sqrt(information), 0.5, 1e-5);
  }
}

TEST(CramerRao, IsInfiniteForSamplesOfOnePoint) {
  const std::vector<LuminanceSample> samples(50, LuminanceSample{0.5f, 0.8f, 0.0f, 0.01f, 0.01f});
  EXPECT_GT(cramer_rao_sigma(samples, Turbidity{3.0}), 1e3);
}

}  // namespace
}  // namespace kasumi
