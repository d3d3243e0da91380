// A loop's sign of life. A call into a driver or a disk may never return: then the loop falls silent.
#pragma once

#include <atomic>
#include <optional>
#include <string_view>

#include "base/clock.hpp"

namespace kasumi {

// How much later than it meant to a loop may turn until it counts as hung.
constexpr Duration kWaitingBound = std::chrono::seconds(5);     // waits for a device
constexpr Duration kDrawingBound = std::chrono::seconds(10);    // may have to wait for a display's driver
constexpr Duration kComputingBound = std::chrono::seconds(30);  // computes, or writes to a disk
constexpr Duration kBehindBound = std::chrono::minutes(10);     // has to wait for all other threads

// Written by one thread, read by any.
class Pulse {
 public:
  explicit Pulse(std::string_view name) : name_(name) {}

  // The loop turns now, and will turn again within this time.
  void turn(Instant now, Duration within) {
    turned_ = now.time_since_epoch().count();
    within_ = within.count();
  }

  std::string_view name() const { return name_; }
  // Since its last turn; empty: it has not begun.
  std::optional<Duration> silent(Instant now) const {
    const Duration::rep turned = turned_;
    if (turned == kNever) return std::nullopt;
    return now.time_since_epoch() - Duration(turned);
  }
  // How long it has been silent, if longer than announced.
  std::optional<Duration> hung(Instant now) const {
    const Duration within(within_);  // before `turned_`: a loop that turns meanwhile is never called hung
    const auto since = silent(now);
    return since && *since > within ? since : std::nullopt;
  }

 private:
  static constexpr Duration::rep kNever = Duration::min().count();
  const std::string_view name_;
  std::atomic<Duration::rep> turned_ = kNever;
  std::atomic<Duration::rep> within_ = 0;
};

}  // namespace kasumi
