// Extinction from the contrast of landmarks (Koschmieder): C = C0 exp(-beta d), C0 unknown but much the same from day
// to day. One channel; docs/physics.md 11.
#pragma once

#include <string>
#include <vector>

#include "estimator/landmarks/contrast.hpp"

namespace kasumi {

// How surfaces and air depart from the law. All relative, standard deviations.
struct ContrastSpread {
  double lit_each = 0.25;       // a surface's light in units of the sky's, from picture to picture, by itself
  double lit_together = 0.3;    // the same of all surfaces at once: sun and overcast
  double known_together = 0.5;  // share of the variance of ContrastLandmark::contrast_sigma that all have in common
  double patchy = 0.1;          // extinction of one path to that of another
  double far_off = 3.0;         // a landmark that the others put farther off than so many sigmas is left out
};

// Which side of the landmarks' reach the air is on.
enum class ExtinctionKind {
  value,
  at_most,   // clearer than these distances can tell: an upper bound of extinction, a lower one of visibility
  at_least,  // thicker: a lower bound of extinction
  nothing    // neither can be told
};

struct Extinction {
  ExtinctionKind kind = ExtinctionKind::nothing;
  std::string reason;                              // for a person; empty for a value
  double per_m = 0.0;                              // the likeliest; where kind is a bound, the likeliest all the same
  double sigma_per_m = 0.0;                        // half of the interval where -2 ln likelihood rises by 1
  double lowest_per_m = 0.0, highest_per_m = 0.0;  // where it rises by 4: 2 sigma; the range's end where it does not
  int landmarks = 0;                               // that entered
  std::vector<std::size_t> left_out;               // far off the others
};

// Contrasts without air and their covariance, n and n x n by rows: what pictures have told of them, to be kept.
struct LearntContrasts {
  std::vector<double> mean, covariance;
};

// The contrasts without air as far as they are known: a normal distribution that pictures narrow.
class LandmarkExtinction {
 public:
  // `clearest_per_m`: extinction of air without any haze, which nothing is below.
  LandmarkExtinction(const std::vector<ContrastLandmark>& landmarks, double camera_altitude_m, double clearest_per_m,
                     int channel, const ContrastSpread& spread = {});

  // Of this picture alone, with what was learnt from others.
  Extinction look(const std::vector<ContrastReading>& readings) const;
  // Takes what a picture tells of the contrasts, its own extinction being quite unknown: how they differ, not how large
  // all are. Not for pictures within the same light: half an hour apart is.
  void learn(const std::vector<ContrastReading>& readings);
  // Seasons change surfaces: so much of what pictures have told goes back to what was known before the first, 0 to 1.
  // The contrasts stay, they are less sure.
  void forget(double share);

  LearntContrasts learnt() const { return {mean_, covariance_}; }
  // Goes on from there. false, and nothing is taken: of other landmarks, or numbers that are no distribution.
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
  std::vector<double> covariance_before_;  // the first picture
};

// All pictures of one camera: the contrasts of each are learnt from the others.
std::vector<Extinction> extinction_of(const LandmarkExtinction& before,
                                      const std::vector<std::vector<ContrastReading>>& pictures);

}  // namespace kasumi
