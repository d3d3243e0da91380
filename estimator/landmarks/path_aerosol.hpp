// The aerosol on the way to the landmarks by all three channels at once: how much of it, and how its extinction goes
// with wavelength (docs/physics.md 11). What changes contrasts (light on the surfaces, patches of haze) changes all
// channels alike, so colour is more certain than each channel alone.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "estimator/air/attenuation.hpp"
#include "estimator/fusion/air_observation.hpp"
#include "estimator/landmarks/contrast.hpp"
#include "estimator/landmarks/extinction.hpp"

namespace kasumi {

// Correlation between channels of the errors that ContrastSpread and a landmark's contrast describe for one.
struct ColourSpread {
  // A surface's light in units of the horizon's, over what its contrast says, and one standard deviation of that share
  // in each channel by itself. Leaves, soil, stone and brick reflect some .45 to .75 as much blue as red. Of what falls
  // on them over the horizon's light, the sun's has .6 as much blue as red, a shaded side's 1.2. Both together are .25
  // to .9. For contrasts between two surfaces there is no such rule.
  glm::dvec3 dull{1.15, 1.0, 0.55}, colour{0.25, 0.15, 0.45};
  double lit = 0.75;               // correlation of changing light: between sun and shade blue changes half as much
  double read = 0.5;               // of errors of reading: the sky's are common, the pixels' are not
  double airlight_together = 0.7;  // correlation of ContrastSpread::airlight from channel to channel
  double learnt_together = 0.7;    // of the errors of what pictures show of a contrast without air
  // Of landmarks of which nothing is said. Each channel's airlight by itself: the horizon is seen through higher air.
  double airlight_colour = 0.035;
  // What the sun adds to surfaces, by channel: they reflect .45 to .75 as much blue as red of .6 as much blue as red.
  glm::dvec3 sunlight{1.1, 1.0, 0.35};
  double sun_each = 0.25, sun = 0.9;  // standard deviation of one surface's share, and correlation of its channels
};

struct PathCovariance {
  double per_m = 0.0;         // variance of extinction
  double and_exponent = 0.0;  // covariance
  double exponent = 0.0;      // variance
};

struct PathAerosol {
  ExtinctionKind kind = ExtinctionKind::nothing;
  std::string reason;                              // for people; empty for a value
  double per_m = 0.0;                              // the aerosol's alone, at 550 nm and the camera's altitude
  double angstrom_exponent = 0.0;                  // known only where its variance is well below 1
  PathCovariance covariance;                       // of a normal distribution like the likelihood
  double lowest_per_m = 0.0, highest_per_m = 0.0;  // 2 sigma, or the end of the range
  int landmarks = 0;                               // that were used
  bool exponent_told = true;                       // false: it lies at the end of what aerosols have, so it is supposed
};

// Belief about the contrasts without air, in all channels jointly. n landmarks; contrast 3 i + c is landmark i's in
// channel c.
class LandmarkColours {
 public:
  LandmarkColours(const Camera& camera, const std::vector<ContrastLandmark>& landmarks, double altitude_m,
                  const ContrastSpread& spread = {}, const ColourSpread& colours = {});

  // `left_out`: landmarks that are not asked.
  // `within`: where to look for the aerosol's extinction, per metre; nothing: everywhere, which takes longer.
  struct Within {
    double lowest_per_m = 0.0, highest_per_m = 0.0;
  };
  PathAerosol estimate(const std::vector<ContrastReading>& readings, std::span<const std::size_t> left_out = {},
                       const std::optional<Within>& within = {}) const;
  // The Cramer-Rao bound: the least covariance of any estimate from such readings in that air.
  PathCovariance bound(const std::vector<ContrastReading>& readings, double per_m, double angstrom_exponent) const;
  // As an observer says it: of all the air, channel by channel; of a bound the bound.
  PathReading reading_of(const PathAerosol& found) const;

  // What pictures have shown in R, G and B, and by how much more than expected each landmark scatters there. At first
  // nothing. What is known of surfaces' colours joins the channels.
  void believe(const std::array<LearntConstants, 3>& channels, const std::array<std::vector<double>, 3>& scatter);
  // The camera shows colours so many times as saturated as they are: contrasts' differences from grey's.
  void set_chroma(double chroma) { chroma_ = chroma; }
  double chroma() const { return chroma_; }
  glm::dvec3 wavelength_nm() const { return wavelength_nm_; }

 private:
  struct Model;
  struct Asked;
  Asked asked(const std::vector<ContrastReading>& readings, std::span<const std::size_t> left_out) const;
  Model model_under(double per_m, double angstrom_exponent, const Asked& asked) const;
  double minus_two_log(double per_m, double angstrom_exponent, const Asked& asked) const;

  AttenuationNodes nodes_;
  glm::dvec3 wavelength_nm_{0};  // where haze is as thick as in the whole channel
  double altitude_m_;
  ContrastSpread spread_;
  ColourSpread colours_;
  std::vector<OpticalPath> paths_;
  std::vector<LawOfLandmark> laws_;
  std::vector<bool> unsaid_;  // nothing of its contrast or of where it faces
  double chroma_ = 1.0;
  ContrastBelief before_, belief_;  // before the first picture, and now; of 3 n contrasts
};

}  // namespace kasumi
