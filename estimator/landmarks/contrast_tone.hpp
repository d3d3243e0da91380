// A camera's tone curve from haze: contrasts of landmarks near and far, light and dark, fade by one law in light alone.
// Under a wrong curve those of dark surfaces in clear air fade too slowly or too fast against all others.
#pragma once

#include <cstddef>
#include <vector>

#include "estimator/landmarks/joint_channel.hpp"

namespace kasumi {

// As sky_fit/tone_curve has it: d ln(light as read) / d ln(light); 1: the response that was supposed is right.
struct ContrastTone {
  double exponent = 1.0;     // the likeliest
  double log_sigma = 0.0;    // one standard deviation of its logarithm; 0: not known
  std::size_t pictures = 0;  // that were used
  bool known() const { return log_sigma > 0.0; }
};

struct ToneSample {
  std::vector<ChannelReading> readings;  // one for each landmark, of the green channel
  double per_m = 0.0;                    // where to begin: its extinction under the response that was supposed
};

// Solves the exponent together with the contrasts without air of all landmarks (`before`: their mean and covariance
// before any picture) and the extinctions of all pictures. Its sigma holds how far the answers without a sixth of the
// pictures and of the landmarks differ. Not known by fewer than 20 pictures or four landmarks before the
// sky. Some 60 ms for 200 pictures of 16.
ContrastTone contrast_tone(const std::vector<ToneSample>& pictures, const std::vector<LawOfLandmark>& laws,
                           const ContrastBelief& before, double usual_per_m, const ContrastSpread& spread = {});

}  // namespace kasumi
