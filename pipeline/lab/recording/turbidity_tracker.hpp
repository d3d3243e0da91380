// T alone over time, as the papers have it: of photographs and recordings under sky_model = "preetham".
#pragma once

#include <optional>

#include "base/clock.hpp"
#include "estimator/fusion/air_tracker.hpp"

namespace kasumi {

// Numbers without a unit are in ln(T - 1): 0.1 is a tenth more or less haze.
struct TrackerLimits {
  double drift_per_root_hour = 0.2;  // standard deviation after an hour without an estimate
  // A usable estimate farther off than this many sigmas, and than the smallest difference, is doubted until this many
  // in a row agree over at least this time: then the air has changed. A bird passes quickly, weather does not.
  double gate = 4.0;
  double least_gate = 0.05;
  int agreeing_doubts = 3;
  Duration doubts_span = std::chrono::seconds(20);
  double largest_rate_per_minute = 0.30;         // half a percent of haze a second: too slow to be seen as a step
  Duration trusted_for = std::chrono::hours(2);  // without a usable estimate
  double largest_trusted_sigma = 0.35;
  std::optional<Aerosol> like{};  // exponent and kind, where they are given
};

// Works in ln(T - 1): haze over pure air, on which visibility and airlight depend (M Eq 24). Monotonic time; a time
// before the last one counts as no time passed.
class TurbidityTracker {
 public:
  explicit TurbidityTracker(TrackerLimits options = {}) : options_(options) {}

  // Accepts an estimate, or rejects it (unusable, not finite, or a lone outlier).
  enum class Verdict { taken, unusable, outlier, restarted };
  Verdict observe(const TurbidityEstimate& estimate, Instant when);
  // The air to show at an instant; empty until the first estimate is accepted. It does not depend on how often it is
  // called.
  std::optional<TrackedAir> at(Instant when) const;

 private:
  struct State {
    double believed = 0.0;  // ln(T - 1)
    double variance = 0.0;  // of it, at `updated`
    double shown = 0.0;     // ln(T - 1) at `updated`
    Instant updated{};
  };
  double shown_at(Instant when) const;
  double variance_at(Instant when) const;

  TrackerLimits options_;
  std::optional<State> state_;
  struct Doubt {
    double value = 0.0;
    int count = 0;
    Instant first{};
  };
  Doubt doubt_;
};

}  // namespace kasumi
