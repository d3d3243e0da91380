#include <cmath>

#include <gtest/gtest.h>

#include "estimator/papers/reference_pixel.hpp"
#include "tests/estimator/turbidity/ceres_reference.hpp"
#include "tests/estimator/turbidity/cramer_rao.hpp"
#include "tests/estimator/turbidity/synthetic_sky.hpp"

namespace kasumi {
namespace {

struct Sky {
  double turbidity = 3.0;
  double sun_zenith_deg = 58.4;
  double sigma = 0.005;     // of ln Y
  double systematic = 0.0;  // a smooth error of the model over the sky
  double outliers = 0.0;    // share of samples that are brighter or darker by any amount
  int count = 100;
  std::uint64_t seed = 1;
};

std::vector<LuminanceSample> samples_of(const Sky& sky) {
  std::vector<LuminanceSample> samples;
  const double s = from_degrees(sky.sun_zenith_deg).value;
  const Direction sun = direction_from({s}, {1.0});
  const auto phase = [&](std::uint64_t j) { return 2.0 * kPi * test::hashed_uniform(100 * sky.seed + j, 0); };
  for (std::uint64_t i = 0; samples.size() < static_cast<std::size_t>(sky.count); ++i) {
    const auto u = [&](std::uint64_t j) { return test::hashed_uniform(100 * sky.seed + j, i); };
    const Direction d = direction_from({std::acos(1.0 - 0.826 * u(1))}, {2.0 * kPi * u(2)});
    const double gamma = angle_between(d, sun).value;
    if (gamma < from_degrees(10).value) continue;
    double log_y = std::log(test::preetham_yxy(sky.turbidity, zenith_angle(d).value, s, gamma).x);
    log_y += sky.sigma * test::hashed_normal(100 * sky.seed + 3, i);
    log_y += sky.systematic * std::sin(3.0 * d.x + phase(6)) * std::cos(2.0 * d.y + phase(7));
    if (u(4) < sky.outliers) log_y += 1.5 * u(5) - 0.4;
    samples.push_back({static_cast<float>(zenith_angle(d).value), static_cast<float>(gamma), static_cast<float>(log_y),
                       static_cast<float>(sky.sigma), static_cast<float>(sky.sigma)});
  }
  return samples;
}

TEST(Solver, FindsTheExactTurbidityOfAPerfectSky) {
  for (const double sun : {10.0, 35.0, 58.4, 80.0})
    for (const double t : {1.75, 2.0, 2.6, 4.0, 7.5, 12.0, 18.0}) {
      const auto solution = solve_turbidity(samples_of({.turbidity = t, .sun_zenith_deg = sun, .sigma = 0.0}));
      ASSERT_TRUE(solution.solved) << t << " " << sun;
      EXPECT_NEAR(solution.turbidity.value, t, 2e-3) << "sun " << sun;  // the samples are single precision
      EXPECT_EQ(solution.inliers, 100);
      EXPECT_FALSE(solution.at_edge);
    }
}

TEST(Solver, IsIndependentOfTheGain) {
  auto samples = samples_of({.turbidity = 4.0});
  const auto before = solve_turbidity(samples);
  for (LuminanceSample& s : samples) s.log_luminance += 7.25f;
  const auto after = solve_turbidity(samples);
  EXPECT_NEAR(after.turbidity.value, before.turbidity.value, 2e-3 * before.sigma / 1e-3);
  EXPECT_NEAR(after.log_gain - before.log_gain, 7.25, 1e-4);
}

// Ceres starts at the truth, so that both converge to the same minimum.
TEST(Solver, RefinesToTheSameOptimumAsCeresWithAutomaticDerivatives) {
  for (const double t : {1.9, 3.0, 6.0, 11.0}) {
    const auto samples = samples_of({.turbidity = t, .sigma = 0.02});
    std::vector<double> weights;
    for (std::size_t i = 0; i < samples.size(); ++i) weights.push_back(1.0 + static_cast<double>(i % 7));
    const auto ceres = test::solve_by_ceres(samples, weights, t);
    const LocalSolution ours = refine_turbidity(samples, weights, Turbidity{1.3 * t});
    EXPECT_TRUE(ours.converged);
    EXPECT_NEAR(ours.turbidity.value, ceres.turbidity, 1e-5 * t);
    EXPECT_NEAR(ours.log_gain, ceres.log_gain, 1e-5);
    EXPECT_NEAR(ours.cost, ceres.cost, 1e-8 * ceres.cost);
  }
}

TEST(Solver, StopsAtTheEdgeOfTheModel) {
  auto samples = samples_of({.turbidity = 1.72, .sigma = 0.0});
  for (LuminanceSample& s : samples)
    s.log_luminance += 1.2f * s.zenith * s.zenith;  // even brighter towards the horizon
  const auto solution = solve_turbidity(samples);
  EXPECT_GE(solution.turbidity.value, kLowestTurbidity.value);
  EXPECT_LE(solution.turbidity.value, kHighestTurbidity.value);
}

TEST(Solver, MarksOutliersAndKeepsTheRest) {
  auto samples = samples_of({.turbidity = 3.0});
  for (std::size_t i = 0; i < 40; ++i)
    samples[i].log_luminance += i % 3 == 0 ? -0.3f : 0.1f + 0.01f * static_cast<float>(i);
  const auto solution = solve_turbidity(samples);
  ASSERT_TRUE(solution.solved);
  for (std::size_t i = 0; i < samples.size(); ++i) EXPECT_EQ(solution.inlier[i] != 0, i >= 40) << i;
  EXPECT_NEAR(solution.turbidity.value, 3.0, 5.0 * solution.sigma);
}

// Over 200 skies: no bias, a scatter at the bound, and a sigma that matches the scatter. 0.15: three standard errors of
// a standard deviation.
TEST(Solver, ReachesTheCramerRaoBoundAndKnowsIt) {
  for (const double outliers : {0.0, 0.3})
    for (const double t : {2.0, 4.0, 9.0}) {
      double sum = 0.0, squares = 0.0, bound = 0.0, stated = 0.0;
      constexpr int kSkies = 200;
      for (std::uint64_t seed = 1; seed <= kSkies; ++seed) {
        const auto samples = samples_of({.turbidity = t, .outliers = outliers, .seed = seed});
        const auto solution = solve_turbidity(samples);
        ASSERT_TRUE(solution.solved);
        const double error = solution.turbidity.value - t;
        sum += error;
        squares += error * error;
        bound += cramer_rao_sigma(samples, Turbidity{t}) / kSkies / std::sqrt(1.0 - outliers);
        stated += solution.sigma / kSkies;
      }
      const double scatter = std::sqrt(squares / kSkies);
      EXPECT_LT(std::abs(sum) / kSkies, 3.5 * scatter / std::sqrt(kSkies)) << t;
      EXPECT_NEAR(scatter / bound, 1.0, 0.17) << "T " << t << ", outliers " << outliers;
      EXPECT_NEAR(stated / scatter, 1.05, 0.25) << "T " << t << ", outliers " << outliers;
    }
}

// A model that is wrong by 8 % all over the sky: the window follows, nearly all samples stay, and sigma includes the
// error.
TEST(Solver, FollowsTheResidualsOfARealSky) {
  int within = 0;
  double squares = 0.0, stated = 0.0;
  constexpr int kSkies = 60;
  for (std::uint64_t seed = 1; seed <= kSkies; ++seed) {
    const auto solution = solve_turbidity(
        samples_of({.turbidity = 2.3, .systematic = 0.16, .outliers = 0.1, .count = 300, .seed = seed}));
    ASSERT_TRUE(solution.solved);
    EXPECT_GT(solution.inliers, 225);
    EXPECT_GT(solution.log_residual, 0.05);
    EXPECT_GT(solution.sigma, 0.02);
    squares += std::pow(solution.turbidity.value - 2.3, 2) / kSkies;
    stated += solution.sigma / kSkies;
    within += std::abs(solution.turbidity.value - 2.3) < 3.0 * solution.sigma ? 1 : 0;
  }
  std::printf("errors %.3f, stated sigma %.3f, %d of %d within 3 sigma\n", std::sqrt(squares), stated, within, kSkies);
  EXPECT_GE(within, 9 * kSkies / 10);
}

TEST(Solver, RefusesTooFewOrInvalidSamples) {
  EXPECT_FALSE(solve_turbidity({}).solved);
  EXPECT_FALSE(solve_turbidity(samples_of({.count = 7})).solved);
  const std::vector<LuminanceSample> one_point(50, LuminanceSample{0.5f, 0.8f, 0.0f, 0.01f, 0.01f});
  EXPECT_FALSE(solve_turbidity(one_point).solved);
}

TEST(Solver, GivesTheSameBitsForTheSameSamples) {
  const auto samples = samples_of({.turbidity = 5.0, .outliers = 0.4});
  EXPECT_EQ(solve_turbidity(samples).turbidity.value, solve_turbidity(samples).turbidity.value);
}

TEST(ReferencePixel, FindsTheTurbidityOfAPerfectSky) {
  for (const double t : {2.0, 4.0, 8.0}) {
    const auto solution = solve_by_reference_pixel(samples_of({.turbidity = t, .sigma = 0.0}), 0);
    ASSERT_TRUE(solution.solved);
    EXPECT_NEAR(solution.turbidity.value, t, 5e-3);
  }
}

// The weakness of the papers' form, which the free gain does not share: an error of the one pixel shifts every
// estimate.
TEST(ReferencePixel, InheritsTheReferencePixelsOwnError) {
  auto samples = samples_of({.turbidity = 8.0, .sigma = 0.0});
  samples[0].log_luminance += 0.004f;  // one step of 8 bits
  EXPECT_GT(std::abs(solve_by_reference_pixel(samples, 0).turbidity.value - 8.0), 0.02);
  EXPECT_LT(std::abs(solve_turbidity(samples).turbidity.value - 8.0), 0.02);
}

}  // namespace
}  // namespace kasumi
