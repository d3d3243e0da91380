// Where most samples agree: the global, robust part of the turbidity solver.
#pragma once

#include <limits>
#include <span>

#include "estimator/turbidity/fitted_sky.hpp"
#include "estimator/turbidity/sky_samples.hpp"

namespace kasumi {

struct Consensus {
  float t = 0.0f;
  float log_gain = 0.0f;
  float window = 0.0f;  // half width in ln Y around the model; about 2.5 standard deviations of the samples inside
  float score = -std::numeric_limits<float>::infinity();  // log likelihood; not finite: nothing agrees
};

// 1. On a grid of T: how many samples share one gain, within windows of several widths. The search is exhaustive, so
// the result does not depend on chance. 2. Graduated non-convexity from the two best candidates, the window following
// the residuals between the two limits. Needs at least two samples with finite values.
Consensus find_consensus(std::span<const LuminanceSample> samples, float narrowest, float widest,
                         const FittedSky& sky = {});

}  // namespace kasumi
