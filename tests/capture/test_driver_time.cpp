#include "capture/driver_time.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace kasumi {
namespace {

using namespace std::chrono_literals;

constexpr Utc kNoon = std::chrono::sys_days{std::chrono::June / 21 / 2026} + 12h;

TEST(DriverTime, AnHonestTimestampIsKept) {
  EXPECT_EQ(bounded_driver_time(12, 345'000'000), Instant{12s + 345ms});
  EXPECT_EQ(bounded_driver_time(std::uint64_t{12'345'000'000}, Instant{13s}), Instant{12s + 345ms});
}

TEST(DriverTime, NoTimestampOverflowsWhatIsDoneWithIt) {
  const Instant now{100s};
  for (const auto ns : {std::uint64_t{1} << 63U, std::numeric_limits<std::uint64_t>::max(), ~std::uint64_t{0} >> 1U}) {
    const auto at = bounded_driver_time(ns, now);
    EXPECT_GT(at, now);
    EXPECT_LT(at - now, 2 * 1'000'000'000s);
  }
  for (const auto seconds : {std::numeric_limits<std::int64_t>::min(), std::numeric_limits<std::int64_t>::max()}) {
    const auto at = bounded_driver_time(seconds, seconds);
    EXPECT_LT(std::chrono::abs(at - now), 2 * 1'000'000'000s);
  }
}

TEST(DriverTime, WithoutATimestampItIsNow) {
  EXPECT_EQ(bounded_driver_time(std::uint64_t{0}, Instant{100s}), Instant{100s});
}

TEST(DriverTime, TheTimeOfDayFollowsOnlyFromATimestampOfThisClock) {
  ManualClock clock(kNoon);
  clock.advance(1000s);
  const auto utc = clock.utc();
  EXPECT_EQ(utc_of_capture(Instant{999s}, clock), utc - 1s);
  EXPECT_EQ(utc_of_capture(Instant{1001s}, clock), utc) << "not yet captured";
  EXPECT_EQ(utc_of_capture(Instant{10s}, clock), utc) << "of another clock";
  EXPECT_EQ(utc_of_capture(Instant{1'000'000'000s}, clock), utc);
}

}  // namespace
}  // namespace kasumi
