// What flows between two pixels in a pass of estimator/haze/diffusion: g, for a row of pixels at a time.
#pragma once

#include <limits>

#include "estimator/haze/diffusion.hpp"

namespace kasumi {

// A pixel's rate: rate_per_px2 of what it wants of the variance between from_px2 and to_px2.
struct FlowRule {
  int offset_px = 1;
  bool mean_of_rates = false;  // g of the two pixels; otherwise the lesser of them
  float rate_per_px2 = 0.0F;
  float from_px2 = 0.0F, to_px2 = std::numeric_limits<float>::infinity();
};
FlowRule explicit_rule(int passes);  // H Eq 12 and 13
FlowRule matched_rule(const MatchedPass& pass);

// Between pixels one[i] and other[i], i < count, which want that much variance.
void conductances(const FlowRule& rule, const float* one_px2, const float* other_px2, int count, float* flow);
// Nothing flows between two surfaces, as the sums of the range's steps tell them.
void stop_at_steps(const float* one_sum, const float* other_sum, int count, float* flow);

}  // namespace kasumi
