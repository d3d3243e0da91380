// The papers' own estimate of T, beside which ours is measured; a kiosk never makes it.
#pragma once

#include "estimator/turbidity/turbidity.hpp"

namespace kasumi {

// The papers' method, to reproduce their tables (M Eq 8, M14 Sect 3): sum over i of |Y_i(T)/Y_ref(T) - Y_i/Y_ref| with
// the one reference sample, RANSAC against clouds.
struct RansacPlan {
  int rounds = 50;
  double fraction = 0.3;    // of the samples used for a hypothesis
  double threshold = 0.08;  // largest error of an inlier's ratio
  std::uint64_t seed = 1;
};
TurbiditySolution solve_by_reference_pixel(std::span<const LuminanceSample> samples, std::size_t reference,
                                           const RansacPlan& options = {});

// EstimateParameters::solve by that, the reference being the sample nearest to the zenith: the part of the sky that is least
// likely to be obstructed (M Sect 3.4).
TurbiditySolver by_reference_pixel(const RansacPlan& options = {});

}  // namespace kasumi
