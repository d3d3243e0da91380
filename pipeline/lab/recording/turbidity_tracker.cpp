#include "pipeline/lab/recording/turbidity_tracker.hpp"

#include <algorithm>
#include <cmath>

#include "base/square.hpp"

namespace kasumi {

namespace {

// Errors of successive estimates are correlated (same lens, same model), so averaging never reduces sigma below this
// share of a single one's.
constexpr double kSharedError = 0.3;
constexpr double kLeastSigma = 0.003;
constexpr double kLeastHaze = 1e-3;  // T - 1

double log_haze(Turbidity turbidity) {
  return std::log(std::max(kLeastHaze, turbidity.value - 1.0));
}
Turbidity turbidity_of(double log_haze) {
  return Turbidity{1.0 + std::exp(log_haze)};
}
Duration passed(Instant from, Instant to) {
  return std::max(Duration{0}, to - from);
}
}  // namespace

double TurbidityTracker::variance_at(Instant when) const {
  return state_->variance + square(options_.drift_per_root_hour) * to_seconds(passed(state_->updated, when)) / 3600.0;
}

double TurbidityTracker::shown_at(Instant when) const {
  const double reach = options_.largest_rate_per_minute * to_seconds(passed(state_->updated, when)) / 60.0;
  return state_->shown + std::clamp(state_->believed - state_->shown, -reach, reach);
}

TurbidityTracker::Verdict TurbidityTracker::observe(const TurbidityEstimate& estimate, Instant when) {
  const double t = estimate.turbidity.value;
  if (!estimate.usable || !std::isfinite(t) || !std::isfinite(estimate.sigma) || t <= 1.0 || estimate.sigma < 0.0)
    return Verdict::unusable;
  const double seen = log_haze(estimate.turbidity);
  const double sigma = std::max(kLeastSigma, estimate.sigma / (t - 1.0));
  if (!state_) {
    state_ = State{seen, square(sigma), seen, when};
    return Verdict::taken;
  }

  const double predicted = variance_at(when), shown = shown_at(when);
  const double surprise = std::abs(seen - state_->believed);
  if (surprise > std::max(options_.least_gate, options_.gate * std::sqrt(predicted + square(sigma)))) {
    const bool same = doubt_.count > 0 && std::abs(seen - doubt_.value) <=
                                              std::max(options_.least_gate, options_.gate * sigma * std::sqrt(2.0));
    if (!same) doubt_ = {seen, 0, when};
    ++doubt_.count;
    doubt_.value = seen;  // the air may still be changing
    if (doubt_.count < options_.agreeing_doubts || passed(doubt_.first, when) < options_.doubts_span)
      return Verdict::outlier;
    state_ = State{seen, square(sigma), shown, std::max(state_->updated, when)};
    doubt_ = {};
    return Verdict::restarted;
  }

  doubt_ = {};
  const double gain = predicted / (predicted + square(sigma));
  const double variance = std::max((1.0 - gain) * predicted, square(kSharedError * sigma));
  state_ = State{state_->believed + gain * (seen - state_->believed), variance, shown, std::max(state_->updated, when)};
  return Verdict::taken;
}

std::optional<TrackedAir> TurbidityTracker::at(Instant when) const {
  if (!state_) return std::nullopt;
  const double shown = shown_at(when), variance = variance_at(when);
  const Turbidity turbidity = turbidity_of(shown);
  TrackedAir tracked;
  tracked.sigma_turbidity = (turbidity.value - 1.0) * std::sqrt(variance + square(state_->believed - shown));
  tracked.air = air_of(turbidity, options_.like, tracked.sigma_turbidity);
  tracked.believed = air_of(turbidity_of(state_->believed), options_.like);
  tracked.age = passed(state_->updated, when);
  tracked.trustworthy = tracked.age <= options_.trusted_for && std::sqrt(variance) <= options_.largest_trusted_sigma;
  tracked.observers = {{AirObserver::sky, tracked.age, tracked.air.aerosol().aod_550}};
  tracked.observers.front().share = 1.0;
  tracked.papers_share = 1.0;
  return tracked;
}

}  // namespace kasumi
