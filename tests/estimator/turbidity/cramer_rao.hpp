// The best possible accuracy of T.
#pragma once

#include <span>

#include "estimator/turbidity/fitted_sky.hpp"

namespace kasumi {

// Lower bound of the standard deviation of T for a free gain and Gaussian errors of the samples' `sigma` (or, with
// quantisation_only, of their `quantisation`); infinite when the samples do not depend on T.
double cramer_rao_sigma(std::span<const LuminanceSample> samples, Turbidity turbidity, bool quantisation_only = false,
                        const FittedSky& sky = {});

}  // namespace kasumi
