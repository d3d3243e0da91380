// Fewer pictures while the machine is too hot, so that it neither slows down at random nor switches itself off.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/clock.hpp"

namespace kasumi {

struct HeatLimits {
  bool fewer_pictures = true;               // false: heat is only reported
  std::optional<double> warm_celsius;       // from here on every second picture; empty: the sensor's own limit
  std::optional<double> hot_celsius;        // from here on every fourth
  double hysteresis_celsius = 5.0;          // so much cooler than a limit before there are more pictures again ..
  Duration hold = std::chrono::minutes(1);  // .. and not sooner after the last change
  friend bool operator==(const HeatLimits&, const HeatLimits&) = default;
};

struct ThermalZone {
  std::string name;  // "cpu-thermal"
  double celsius = 0.0;
  double warm_celsius = 75.0;  // its own limits, or usual ones
  double hot_celsius = 85.0;
};

// The zone nearest to its limits, the configured ones where there are any; null without zones.
const ThermalZone* hottest(const std::vector<ThermalZone>& zones, const HeatLimits& options);

// A pure state machine: fewer pictures at once, more again one step at a time.
class HeatGovernor {
 public:
  // `throttled`: the firmware slows the machine down now. Returns of how many pictures one is shown: 1, 2 or 4.
  int step(Instant now, const std::vector<ThermalZone>& zones, bool throttled, const HeatLimits& options);

 private:
  int one_of_ = 1;
  std::optional<Instant> since_;
};

}  // namespace kasumi
