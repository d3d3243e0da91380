// The state of the air over a recording, as a drawing: amount and its sigma, and what each observer said alone.
#pragma once

#include <string>
#include <vector>

#include "base/clock.hpp"
#include "estimator/fusion/air_tracker.hpp"

namespace kasumi {

class AirCurve {
 public:
  // In order of time.
  void add(Utc utc, const TrackedAir& state);
  bool empty() const { return moments_.empty(); }
  // SVG: optical depth over time. A band of one sigma around the state, pale where the air is supposed; a mark with its
  // own sigma for each observer's reading.
  std::string svg() const;

 private:
  struct Reading {
    AirObserver by = AirObserver::sky;
    double aod_550 = 0.0, sigma = 0.0;
  };
  struct Moment {
    Utc utc{};
    double aod_550 = 0.0, sigma = 0.0;
    bool supposed = false;
    std::vector<Reading> readings;  // new at this moment
  };
  double highest() const;

  std::vector<Moment> moments_;
};

}  // namespace kasumi
