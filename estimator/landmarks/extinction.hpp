// Extinction from the contrast of landmarks (Koschmieder): C = C0 exp(-beta d), with C0 unknown but nearly constant
// from day to day. One channel; docs/physics.md 11.
#pragma once

#include <string>
#include <vector>

#include "estimator/landmarks/contrast.hpp"
#include "estimator/landmarks/joint_channel.hpp"

namespace kasumi {

// Whether the air is within the landmarks' measuring range.
enum class ExtinctionKind {
  value,
  at_most,   // clearer than these distances can resolve: an upper bound of extinction, a lower one of visibility
  at_least,  // thicker: a lower bound of extinction
  nothing    // not even a bound
};

struct Extinction {
  ExtinctionKind kind = ExtinctionKind::nothing;
  std::string reason;                              // for people; empty for a value
  double per_m = 0.0;                              // the most likely value, also where kind is a bound
  double sigma_per_m = 0.0;                        // half of the interval where -2 ln likelihood rises by 1
  double lowest_per_m = 0.0, highest_per_m = 0.0;  // where it rises by 4 (2 sigma), or the end of the range
  int landmarks = 0;                               // that were used
  std::vector<std::size_t> left_out;               // far from the others' prediction
};

// The laws of landmarks with their priors, in one channel.
std::vector<LawOfLandmark> laws_of(const std::vector<ContrastLandmark>& landmarks, double camera_altitude_m);
ContrastBelief belief_before(const std::vector<ContrastLandmark>& landmarks, const ContrastSpread& spread);

// The extinction that one picture shows, under a belief about what is constant of its landmarks.
class LandmarkExtinction {
 public:
  // `clearest_per_m`: extinction of air without any haze, the lower limit.
  LandmarkExtinction(const std::vector<ContrastLandmark>& landmarks, double camera_altitude_m, double clearest_per_m,
                     int channel, const ContrastSpread& spread = {});

  // At first that before the first picture.
  void believe(ContrastBelief belief) { belief_ = std::move(belief); }
  const ContrastBelief& belief() const { return belief_; }

  // From this picture alone. Surfaces in the sun are used only where there are no others.
  Extinction estimate(const std::vector<ContrastReading>& readings) const;

 private:
  struct Fit;
  double plausible_rise(std::size_t landmark, const ContrastReading& reading, double per_m, Plausible* found) const;
  Fit fit(const std::vector<ContrastReading>& readings, const std::vector<std::size_t>& used,
          const std::vector<std::size_t>& left_out) const;
  std::vector<std::size_t> usable(const std::vector<ContrastReading>& readings) const;
  std::vector<std::size_t> agreeing(const std::vector<ContrastReading>& readings,
                                    const std::vector<std::size_t>& usable, std::vector<std::size_t>& left_out) const;

  std::vector<LawOfLandmark> laws_;
  int channel_;
  ContrastSpread spread_;
  std::vector<double> grid_per_m_;  // evenly spaced in its logarithm
  ContrastBelief belief_;
};

}  // namespace kasumi
