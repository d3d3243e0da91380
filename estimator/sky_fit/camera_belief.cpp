#include "estimator/sky_fit/camera_belief.hpp"

#include <algorithm>
#include <cmath>

#include "base/square.hpp"

namespace kasumi {

CameraBelief belief_after(std::span<const ToneSight> pictures, const CameraBelief& before) {
  constexpr double kAlike = 0.1;     // of the logarithm: how far skies of one camera are apart
  constexpr double kCertain = 0.05;  // their common error, which no number of pictures reduces
  const double prior = 1.0 / square(before.sigma_log_exponent);
  double weight = prior, sum = prior * before.log_exponent;
  for (const ToneSight& picture : pictures) {
    if (!(picture.sigma > 0.0)) continue;
    const double variance = square(picture.sigma / picture.exponent);
    // What the picture says by itself, without the belief it was asked under.
    const double own = 1.0 / variance - prior;
    if (!(own > 0.0)) continue;
    const double mean = (std::log(picture.exponent) / variance - prior * before.log_exponent) / own;
    const double share = 1.0 / (1.0 / own + square(kAlike));
    weight += share;
    sum += share * mean;
  }
  CameraBelief after = before;
  after.log_exponent = sum / weight;
  after.sigma_log_exponent = std::min(before.sigma_log_exponent, std::hypot(std::sqrt(1.0 / weight), kCertain));
  return after;
}

}  // namespace kasumi
