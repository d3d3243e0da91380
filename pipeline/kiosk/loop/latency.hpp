// Capture-to-display latency of each picture.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>

#include "base/clock.hpp"

namespace kasumi {

struct LatencySummary {
  double median_ms = 0.0;  // 0 when there are no `pictures`
  double p95_ms = 0.0;
  double max_ms = 0.0;
  std::uint64_t pictures = 0;  // measured
  std::uint64_t negative = 0;  // further ones, whose camera stamp lies after their flip: unusable
};

// A histogram whose bins each are 1 % wider than the one before, from .1 ms to hours: constant memory over months and
// the same relative precision on fast and slow machines.
class LatencyHistogram {
 public:
  void add(Duration latency);
  std::optional<LatencySummary> summary() const;  // quantiles to .5 % or .1 ms

 private:
  static constexpr std::size_t kBins = 1900;
  double quantile_ms(double share) const;
  std::array<std::uint32_t, kBins> bins_{};
  std::uint64_t count_ = 0;
  std::uint64_t negative_ = 0;
  double max_ms_ = 0.0;
};

// Remembers which frame went into which picture until its flip.
class LatencyWatch {
 public:
  void shown(std::uint64_t picture, Instant captured_at);
  void flipped(std::uint64_t picture, Instant at);
  void forget_pending() { pending_.clear(); }   // the display is gone
  std::optional<LatencySummary> take_minute();  // since the last call
  std::optional<LatencySummary> whole() const { return whole_.summary(); }

 private:
  struct Pending {
    std::uint64_t picture;
    Instant captured_at;
  };
  std::deque<Pending> pending_;
  LatencyHistogram minute_, whole_;
};

}  // namespace kasumi
