// What is known of an unmeasured camera, before a picture and after several.
#pragma once

#include <span>

namespace kasumi {

// What is known beforehand of what a camera does to its pictures; the standard deviations are those among unmeasured ones.
struct CameraBelief {
  double log_exponent = 0.0;  // ln of d ln(light as read) / d ln(light), where the supposed response is sRGB
  double sigma_log_exponent = 0.35;
  double rim_loss = 0.35;         // of ln light at the rim
  double white_balance = 0.15;    // of ln(R/G) and ln(B/G)
  double sigma_altitude_m = 0.0;  // of where it stands; 0: that is known
};

// A tone exponent by one picture, under a prior.
struct ToneSight {
  double exponent = 1.0, sigma = 0.0;
};
// The posterior after several pictures of a camera, each read under the same prior `before`. Pictures of one camera
// share an error that the sky model lacks, so their number alone does not make the exponent certain.
CameraBelief belief_after(std::span<const ToneSight> pictures, const CameraBelief& before = {});

}  // namespace kasumi
