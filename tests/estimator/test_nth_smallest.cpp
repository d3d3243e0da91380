// Order statistics by counting, against sorting.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "base/statistics.hpp"
#include "estimator/nth_smallest.hpp"

namespace kasumi {
namespace {

TEST(NthSmallest, IsTheValueThatSortingFinds) {
  std::mt19937 random(5);
  std::normal_distribution<float> normal(0.3f, 2.0f);
  for (const std::size_t count : {1u, 2u, 255u, 256u, 5000u}) {
    std::vector<float> values(count);
    for (float& value : values) value = normal(random);
    for (std::size_t i = 0; i < count; i += 7) values[i] = std::round(values[i]);  // many alike
    std::vector<float> sorted = values;
    std::ranges::sort(sorted);
    for (std::size_t n = 0; n < count; n += 1 + count / 40) EXPECT_EQ(nth_smallest(values, n), sorted[n]) << count;
    EXPECT_EQ(nth_smallest(values, count - 1), sorted.back()) << count;
    EXPECT_EQ(counted_median(values), median(values)) << count;
    EXPECT_EQ(counted_quantile(values, 0.9995), quantile(values, 0.9995)) << count;
  }
  EXPECT_EQ(nth_smallest(std::vector<float>(1000, 0.25f), 700), 0.25f) << "all alike";
}

}  // namespace
}  // namespace kasumi
