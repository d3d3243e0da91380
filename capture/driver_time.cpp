#include "capture/driver_time.hpp"

#include <algorithm>

namespace kasumi {

namespace {

constexpr std::int64_t kLargestTime_s = 1'000'000'000;
constexpr std::int64_t kNanoseconds = 1'000'000'000;  // of a second
constexpr Duration kOldestCapture = std::chrono::seconds(60);

}  // namespace

Instant bounded_driver_time(std::int64_t seconds, std::int64_t nanoseconds) {
  return Instant{std::chrono::seconds(std::clamp(seconds, -kLargestTime_s, kLargestTime_s)) +
                 std::chrono::nanoseconds(std::clamp<std::int64_t>(nanoseconds, 0, kNanoseconds - 1))};
}

Instant bounded_driver_time(std::uint64_t nanoseconds, Instant now) {
  if (nanoseconds == 0) return now;
  const auto bounded = std::min<std::uint64_t>(nanoseconds, kLargestTime_s * kNanoseconds);
  return Instant{Duration{static_cast<Duration::rep>(bounded)}};
}

Utc utc_of_capture(Instant captured_at, const Clock& clock) {
  const auto age = clock.now() - captured_at;
  return clock.utc() - (age > Duration::zero() && age < kOldestCapture ? age : Duration::zero());
}

}  // namespace kasumi
