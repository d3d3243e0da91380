// The conductance g between two pixels in a pass of estimator/haze/diffusion, computed for a row of pixels at a time.
#pragma once

#include <limits>

#include "estimator/haze/diffusion.hpp"

namespace kasumi {

// A pixel's rate: rate_per_px2 times the part of its wanted variance between from_px2 and to_px2.
struct FlowRule {
  int offset_px = 1;
  bool mean_of_rates = false;  // g is the mean of the two pixels' rates; otherwise the lesser
  float rate_per_px2 = 0.0F;
  float from_px2 = 0.0F, to_px2 = std::numeric_limits<float>::infinity();
};
FlowRule explicit_rule(int passes);  // H Eq 12 and 13
FlowRule matched_rule(const MatchedPass& pass);

// Between pixels one[i] and other[i], i < count, with those wanted variances.
void conductances(const FlowRule& rule, const float* one_px2, const float* other_px2, int count, float* flow);
// Sets the flow to zero between two surfaces, as given by the sums of the range's steps.
void stop_at_steps(const float* one_sum, const float* other_sum, int count, float* flow);

}  // namespace kasumi
