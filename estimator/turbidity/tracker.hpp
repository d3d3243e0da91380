// T over time: what the renderer is given between, and instead of, single estimates.
#pragma once

#include <optional>

#include "base/clock.hpp"
#include "estimator/atmosphere.hpp"

namespace kasumi {

// Numbers without a unit are of ln(T - 1): 0.1 is a tenth more or less haze.
struct TrackerOptions {
  double drift_per_root_hour = 0.2;  // standard deviation after an hour without news
  // A usable estimate further off than so many sigmas, and than the least, is doubted until so many in a row say the
  // same over at least this time: then the air has changed. A bird is quick, weather is not.
  double gate = 4.0;
  double least_gate = 0.05;
  int agreeing_doubts = 3;
  Duration doubts_span = std::chrono::seconds(20);
  double largest_rate_per_minute = 0.30;         // half a percent of haze a second: below what an eye takes for a step
  Duration trusted_for = std::chrono::hours(2);  // without a usable estimate
  double largest_trusted_sigma = 0.35;
};

struct TrackedTurbidity {
  Turbidity turbidity;       // shown: moves slowly
  Turbidity target;          // believed: where the shown one is going
  double sigma = 0.0;        // standard deviation of `turbidity` as today's T, the distance to the target included
  Duration age{};            // since the last estimate that was taken in
  bool trustworthy = false;  // young and certain enough to be called today's air
};

// Works in ln(T - 1): haze over pure air, to which visibility and airlight are tied (M Eq 24). Monotonic time; times
// that run backwards count as no time passed.
class TurbidityTracker {
 public:
  explicit TurbidityTracker(TrackerOptions options = {}) : options_(options) {}

  // Takes an estimate in, or rejects it (unusable, not finite, or a lone outlier).
  enum class Verdict { taken, unusable, outlier, restarted };
  Verdict observe(const TurbidityEstimate& estimate, Instant when);
  // What to show at an instant; empty until the first estimate was taken. Calling it more or less often shows the same.
  std::optional<TrackedTurbidity> at(Instant when) const;

 private:
  struct State {
    double believed = 0.0;  // ln(T - 1)
    double variance = 0.0;  // of it, at `updated`
    double shown = 0.0;     // ln(T - 1) at `updated`
    Instant updated{};
  };
  double shown_at(Instant when) const;
  double variance_at(Instant when) const;

  TrackerOptions options_;
  std::optional<State> state_;
  struct Doubt {
    double value = 0.0;
    int count = 0;
    Instant first{};
  };
  Doubt doubt_;
};

}  // namespace kasumi
