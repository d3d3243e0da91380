// Clocks that tests can control. Monotonic time orders events and sets deadlines; UTC places the sun.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>

namespace kasumi {

using Duration = std::chrono::nanoseconds;

struct MonotonicClockTag {  // so that a monotonic instant is never mistaken for UTC
  using rep = Duration::rep;
  using period = Duration::period;
  using duration = Duration;
  using time_point = std::chrono::time_point<MonotonicClockTag>;
  static constexpr bool is_steady = true;
};
using Instant = MonotonicClockTag::time_point;
using Utc = std::chrono::sys_time<Duration>;

inline double to_seconds(Duration duration) {
  return std::chrono::duration<double>(duration).count();
}
inline Duration from_seconds(double seconds) {
  return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(seconds));
}

class Clock {
 public:
  virtual ~Clock() = default;
  virtual Instant now() const = 0;
  virtual Utc utc() const = 0;
  // BLOCKS until now() >= instant, or until interrupt() is called from another thread.
  virtual void sleep_until(Instant instant) = 0;
  virtual void interrupt() = 0;  // wakes every sleeper; later sleeps return at once
};

// The machine's clocks.
class SystemClock final : public Clock {
 public:
  Instant now() const override;
  Utc utc() const override;
  void sleep_until(Instant instant) override;
  void interrupt() override;

 private:
  std::mutex mutex_;
  std::condition_variable woken_;
  bool interrupted_ = false;
};

// Stands still until it is advanced: sleepers wait for advance().
class ManualClock final : public Clock {
 public:
  explicit ManualClock(Utc start) : start_(start) {}
  Instant now() const override;
  Utc utc() const override;
  void sleep_until(Instant instant) override;
  void interrupt() override;
  void advance(Duration step);

 private:
  mutable std::mutex mutex_;
  std::condition_variable turned_;
  Utc start_;
  Instant now_{};
  bool interrupted_ = false;
};

// For running as fast as possible: a sleep takes no time, the clock jumps to the requested instant.
class FastForwardClock final : public Clock {
 public:
  explicit FastForwardClock(Utc start) : start_(start) {}
  Instant now() const override;
  Utc utc() const override;
  void sleep_until(Instant instant) override;
  void interrupt() override {}

 private:
  mutable std::mutex mutex_;
  Utc start_;
  Instant now_{};
};

}  // namespace kasumi
