#include "pipeline/kiosk/loop/latency.hpp"
#include "tests/must.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace kasumi {
namespace {

using namespace std::chrono_literals;

Duration milliseconds(double ms) {
  return std::chrono::duration_cast<Duration>(std::chrono::duration<double, std::milli>(ms));
}

double quantile(std::vector<double> sorted, double share) {
  return sorted[static_cast<std::size_t>(std::ceil(share * static_cast<double>(sorted.size()))) - 1];
}

TEST(Latency, QuantilesAreTrueToHalfAPercentFromMillisecondsToMinutes) {
  for (const double scale_ms : {3.0, 30.0, 700.0, 60e3}) {
    std::mt19937_64 random(7);
    std::vector<double> latencies;
    LatencyHistogram histogram;
    for (int i = 0; i < 1001; ++i) {
      latencies.push_back(scale_ms * std::exp(static_cast<double>(random() >> 11) * 0x1p-53));
      histogram.add(milliseconds(latencies.back()));
    }
    std::sort(latencies.begin(), latencies.end());
    const auto summary = must(histogram.summary());
    EXPECT_EQ(summary->pictures, 1001u);
    EXPECT_NEAR(summary->median_ms / quantile(latencies, 0.5), 1.0, 0.0051) << scale_ms << " ms";
    EXPECT_NEAR(summary->p95_ms / quantile(latencies, 0.95), 1.0, 0.0051) << scale_ms << " ms";
    EXPECT_NEAR(summary->max_ms, latencies.back(), 1e-3) << scale_ms << " ms";
  }
}

TEST(Latency, TheShortestAndTheLongestHaveTheirPlace) {
  LatencyHistogram histogram;
  EXPECT_FALSE(histogram.summary());
  for (const Duration latency : {Duration{0}, Duration{0}, Duration{1000h}}) histogram.add(latency);
  const auto summary = must(histogram.summary());
  EXPECT_LE(summary->median_ms, 0.1);
  EXPECT_DOUBLE_EQ(summary->max_ms, 3.6e9);
}

TEST(Latency, PicturesStampedAfterTheirFlipAreCountedApart) {
  LatencyHistogram histogram;
  histogram.add(-5ms);
  ASSERT_TRUE(histogram.summary());
  EXPECT_EQ(histogram.summary()->pictures, 0u);
  EXPECT_EQ(histogram.summary()->negative, 1u);
  for (const Duration latency : {Duration{-1ms}, Duration{30ms}, Duration{-1ns}}) histogram.add(latency);
  EXPECT_EQ(histogram.summary()->pictures, 1u);
  EXPECT_EQ(histogram.summary()->negative, 3u);
  EXPECT_NEAR(histogram.summary()->median_ms, 30.0, 0.2);
}

TEST(Latency, APictureCountsFromItsFrameToItsOwnFlip) {
  LatencyWatch watch;
  const Instant start{};
  watch.shown(1, start);
  watch.shown(2, start + 10ms);
  watch.shown(3, start + 20ms);
  watch.flipped(2, start + 50ms);  // the flip of picture 1 never came
  watch.flipped(2, start + 90ms);
  const auto minute = must(watch.take_minute());
  EXPECT_EQ(minute->pictures, 1u);
  EXPECT_NEAR(minute->max_ms, 40.0, 1e-6);
  EXPECT_FALSE(watch.take_minute());
  watch.flipped(3, start + 80ms);
  EXPECT_NEAR(watch.whole()->max_ms, 60.0, 1e-6);
  EXPECT_EQ(watch.whole()->pictures, 2u);
}

}  // namespace
}  // namespace kasumi
