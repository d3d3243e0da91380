#include "estimator/haze/conductance.hpp"

#include <algorithm>
#include <cmath>

#include "estimator/haze/range.hpp"

namespace kasumi {

FlowRule explicit_rule(int passes) {
  return {.mean_of_rates = true, .rate_per_px2 = 0.5F / static_cast<float>(passes)};
}

FlowRule matched_rule(const MatchedPass& pass) {
  return {.offset_px = pass.offset_px,
          .rate_per_px2 = static_cast<float>(0.5 / (static_cast<double>(pass.offset_px) * pass.offset_px)),
          .from_px2 = static_cast<float>(pass.from_px2),
          .to_px2 = static_cast<float>(pass.from_px2 + pass.variance_px2)};
}

void conductances(const FlowRule& rule, const float* one_px2, const float* other_px2, int count, float* flow) {
  const float half = 0.5F * rule.rate_per_px2, whole = rule.rate_per_px2, from = rule.from_px2, to = rule.to_px2;
  if (rule.mean_of_rates) {
    for (int i = 0; i < count; ++i) flow[i] = half * (one_px2[i] + other_px2[i]);
    return;
  }
  for (int i = 0; i < count; ++i)
    flow[i] = whole * (std::min(std::max(std::min(one_px2[i], other_px2[i]), from), to) - from);
}

void stop_at_steps(const float* one_sum, const float* other_sum, int count, float* flow) {
  // 1 over the width of the ramp between the two.
  constexpr float kPerDifference = 1.0F / (kOtherSurface - kSameSurface);
  for (int i = 0; i < count; ++i) {
    float apart = std::abs(one_sum[i] - other_sum[i]);
    apart = std::min(apart, kRangeStepTurn - apart);
    apart = std::min(std::max(apart, kSameSurface), kOtherSurface);
    const float joined = (kOtherSurface - apart) * kPerDifference;
    flow[i] *= joined * joined * (3.0F - 2.0F * joined);
  }
}

}  // namespace kasumi
