#include "pipeline/site/config/heat_governor.hpp"

#include <algorithm>

namespace kasumi {

namespace {

double warm(const ThermalZone& zone, const HeatLimits& options) {
  return options.warm_celsius.value_or(zone.warm_celsius);
}
double hot(const ThermalZone& zone, const HeatLimits& options) {
  return options.hot_celsius.value_or(zone.hot_celsius);
}

// If all were `hotter` by so much.
int demanded_by(const std::vector<ThermalZone>& zones, const HeatLimits& options, double hotter_celsius) {
  int one_of = 1;
  for (const auto& zone : zones) {
    const double celsius = zone.celsius + hotter_celsius;
    one_of = std::max(one_of, celsius >= hot(zone, options) ? 4 : celsius >= warm(zone, options) ? 2 : 1);
  }
  return one_of;
}

}  // namespace

const ThermalZone* hottest(const std::vector<ThermalZone>& zones, const HeatLimits& options) {
  const auto found = std::min_element(zones.begin(), zones.end(), [&](const ThermalZone& a, const ThermalZone& b) {
    return hot(a, options) - a.celsius < hot(b, options) - b.celsius;
  });
  return found == zones.end() ? nullptr : &*found;
}

int HeatGovernor::step(Instant now, const std::vector<ThermalZone>& zones, bool throttled, const HeatLimits& options) {
  if (!options.fewer_pictures) {
    since_.reset();
    return one_of_ = 1;
  }
  const bool held = since_ && now - *since_ < options.hold;
  int demanded = demanded_by(zones, options, 0.0);
  // The firmware says only that it is too much: when half of the pictures do not help, a quarter may.
  if (throttled) demanded = std::max(demanded, held ? std::max(one_of_, 2) : std::min(2 * one_of_, 4));
  const int allowed = std::max(demanded, demanded_by(zones, options, options.hysteresis_celsius));
  const int before = one_of_;
  if (demanded > one_of_)
    one_of_ = demanded;
  else if (allowed < one_of_ && !held)
    one_of_ /= 2;
  if (one_of_ != before) since_ = now;
  return one_of_;
}

}  // namespace kasumi
