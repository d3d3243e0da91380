// Order statistics against their definitions and the normal distribution.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <numbers>
#include <random>

#include "base/statistics.hpp"

namespace kasumi {
namespace {

std::vector<double> normal_values(std::size_t count, double sigma) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal(0.0, sigma);
  std::vector<double> values(count);
  for (double& value : values) value = normal(random);
  return values;
}

TEST(Median, IsTheMiddleOfAnOddCount) {
  EXPECT_EQ(median(std::vector{5.0, 1.0, 4.0, 2.0, 3.0}), 3.0);
}

TEST(Median, IsTheUpperOfTheMiddleTwoOfAnEvenCount) {
  EXPECT_EQ(median(std::vector{4.0, 1.0, 3.0, 2.0}), 3.0);
  EXPECT_EQ(median(std::vector{2, 1}), 2);
}

TEST(Median, OfOneValueIsThatValueAndOfNoneIsZero) {
  EXPECT_EQ(median(std::vector{7.5f}), 7.5f);
  EXPECT_EQ(median(std::vector<double>{}), 0.0);
  EXPECT_EQ(median(std::vector<std::chrono::nanoseconds>{}), std::chrono::nanoseconds{0});
}

TEST(Median, LeavesTheCallersValuesInOrder) {
  const std::vector<double> values{9.0, 1.0, 5.0};
  EXPECT_EQ(median(values), 5.0);
  EXPECT_EQ(values, (std::vector{9.0, 1.0, 5.0}));
}

TEST(Median, InPlaceIsTheSame) {
  auto values = normal_values(1000, 2.0);
  const double expected = median(values);
  EXPECT_EQ(median_in_place(values), expected);
}

TEST(Median, IsNotAffectedByAMinorityOfOutliers) {
  std::vector<double> values(51, 1.0);
  values.resize(101, 1e12);
  EXPECT_EQ(median(values), 1.0);
}

TEST(Quantile, IsTheElementAtThatFractionOfTheOrder) {
  std::vector<int> values(101);
  for (int i = 0; i <= 100; ++i) values[static_cast<std::size_t>(i)] = (37 * i) % 101;
  for (const int percent : {0, 25, 50, 98, 100}) EXPECT_EQ(quantile(values, percent / 100.0), percent);
}

TEST(Quantile, RoundsDownToTheValueBelow) {
  EXPECT_EQ(quantile(std::vector{1.0, 2.0, 3.0, 4.0}, 0.5), 2.0);
  EXPECT_EQ(quantile(std::vector{1.0, 2.0, 3.0, 4.0}, 0.99), 3.0);
}

TEST(Quantile, OfOneValueIsThatValueAndOfNoneIsZero) {
  EXPECT_EQ(quantile(std::vector{7.5}, 0.3), 7.5);
  EXPECT_EQ(quantile(std::vector<float>{}, 0.5), 0.0f);
}

TEST(Quantile, OrdersByAProjection) {
  struct Seen {
    int name = 0;
    double luminance = 0.0;
  };
  const std::vector<Seen> seen{{1, 30.0}, {2, 10.0}, {3, 20.0}};
  EXPECT_EQ(quantile(seen, 0.5, &Seen::luminance).name, 3);
}

TEST(RobustSigma, IsTheStandardDeviationOfNormalResidualsDespiteOutliers) {
  auto values = normal_values(200'000, 0.7);
  EXPECT_NEAR(robust_sigma(values) / 0.7, 1.0, 0.01);
  for (std::size_t i = 0; i < values.size(); i += 50) values[i] = 1e9;  // 2 %
  EXPECT_NEAR(robust_sigma(values) / 0.7, 1.0, 0.05);
}

TEST(RobustSigma, OfNothingIsZero) {
  EXPECT_EQ(robust_sigma(std::vector<double>{}), 0.0);
}

TEST(RobustSigma, HasTheNormalDistributionsConstants) {
  // Half of a normal sample lies within sigma / kSigmaOverMedianSize of its mean.
  EXPECT_NEAR(std::erf(1.0 / kSigmaOverMedianSize / std::numbers::sqrt2), 0.5, 1e-5);
  EXPECT_NEAR(kMedianLengthOverSigma, std::sqrt(2.0 * std::numbers::ln2), 1e-4);
  EXPECT_NEAR(kMedianErrorOverMeanError, std::sqrt(std::numbers::pi / 2.0), 1e-4);
}

TEST(TukeyWeight, FallsFromOneToZeroAtItsCutoffOnBothSides) {
  EXPECT_EQ(tukey_weight(0.0), 1.0);
  EXPECT_EQ(tukey_weight(0.5), 0.5625);
  EXPECT_EQ(tukey_weight(-0.5), 0.5625);
  EXPECT_EQ(tukey_weight(1.0), 0.0);
  EXPECT_EQ(tukey_weight(-1e300), 0.0);
}

}  // namespace
}  // namespace kasumi
