#include "base/clock.hpp"

#include <algorithm>

namespace kasumi {

Instant SystemClock::now() const {
  return Instant{std::chrono::duration_cast<Duration>(std::chrono::steady_clock::now().time_since_epoch())};
}

Utc SystemClock::utc() const {
  return std::chrono::time_point_cast<Duration>(std::chrono::system_clock::now());
}

void SystemClock::sleep_until(Instant instant) {
  std::unique_lock lock(mutex_);
  woken_.wait_until(lock, std::chrono::steady_clock::time_point{instant.time_since_epoch()},
                    [this] { return interrupted_; });
}

void SystemClock::interrupt() {
  const std::lock_guard lock(mutex_);
  interrupted_ = true;
  woken_.notify_all();
}

Instant ManualClock::now() const {
  const std::lock_guard lock(mutex_);
  return now_;
}

Utc ManualClock::utc() const {
  const std::lock_guard lock(mutex_);
  return start_ + now_.time_since_epoch();
}

void ManualClock::sleep_until(Instant instant) {
  std::unique_lock lock(mutex_);
  turned_.wait(lock, [&] { return interrupted_ || now_ >= instant; });
}

void ManualClock::interrupt() {
  const std::lock_guard lock(mutex_);
  interrupted_ = true;
  turned_.notify_all();
}

void ManualClock::advance(Duration step) {
  const std::lock_guard lock(mutex_);
  now_ += step;
  turned_.notify_all();
}

Instant FastForwardClock::now() const {
  const std::lock_guard lock(mutex_);
  return now_;
}

Utc FastForwardClock::utc() const {
  const std::lock_guard lock(mutex_);
  return start_ + now_.time_since_epoch();
}

void FastForwardClock::sleep_until(Instant instant) {
  const std::lock_guard lock(mutex_);
  now_ = std::max(now_, instant);
}

}  // namespace kasumi
