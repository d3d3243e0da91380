// Extinction from the contrast of landmarks (Koschmieder): C = C0 exp(-beta d), with C0 unknown but nearly constant
// from day to day. One channel; docs/physics.md 11.
#pragma once

#include <string>
#include <vector>

#include "estimator/landmarks/contrast.hpp"

namespace kasumi {

// How surfaces and air deviate from that law. All are relative standard deviations.
struct ContrastSpread {
  double lit_each = 0.25;       // a surface's light in units of the sky's, from picture to picture, independently
  double lit_together = 0.3;    // the same for all surfaces at once: sun and overcast
  double known_together = 0.5;  // share of the variance of ContrastLandmark::contrast_sigma that all have in common
  double patchy = 0.1;          // extinction of one path relative to another
  double far_off = 3.0;         // a landmark farther from the others' prediction than this, in sigmas, is left out
};

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

// Contrasts without air and their covariance (n and n x n by rows) as learnt from pictures, to be stored.
struct LearntContrasts {
  std::vector<double> mean, covariance;
};

// Belief about the contrasts without air: a normal distribution that pictures narrow.
class LandmarkExtinction {
 public:
  // `clearest_per_m`: extinction of air without any haze, the lower limit.
  LandmarkExtinction(const std::vector<ContrastLandmark>& landmarks, double camera_altitude_m, double clearest_per_m,
                     int channel, const ContrastSpread& spread = {});

  // From this picture alone, with what was learnt from others.
  Extinction estimate(const std::vector<ContrastReading>& readings) const;
  // Updates the contrasts from a picture whose own extinction is taken as unknown: it shows how they differ, not how
  // large all of them are. Pictures must be taken in different light: half an hour apart is enough.
  void learn(const std::vector<ContrastReading>& readings);
  // Seasons change surfaces: this share (0 to 1) of what pictures have taught returns to the prior. The contrasts stay,
  // but become less certain.
  void forget(double share);

  LearntContrasts learnt() const { return {mean_, covariance_}; }
  // Continues from there. false, with nothing changed, if it belongs to other landmarks or is not a valid distribution.
  bool resume(const LearntContrasts& learnt);

  const std::vector<double>& contrasts() const { return mean_; }  // without air
  double contrast_sigma(std::size_t landmark) const;

 private:
  struct Fit;
  Fit fit(const std::vector<ContrastReading>& readings, const std::vector<std::size_t>& used) const;
  std::vector<std::size_t> usable(const std::vector<ContrastReading>& readings) const;
  std::vector<std::size_t> agreeing(const std::vector<ContrastReading>& readings, std::vector<std::size_t> used,
                                    std::vector<std::size_t>* left_out) const;

  std::vector<double> path_m_;
  std::vector<bool> before_sky_;
  int channel_;
  ContrastSpread spread_;
  std::vector<double> grid_per_m_;  // evenly spaced in its logarithm
  std::vector<double> mean_, covariance_;
  std::vector<double> covariance_before_;  // before the first picture
};

}  // namespace kasumi
