// The same weighted least squares by Ceres with automatic derivatives: the reference for the hand-written solver.
#pragma once

#include <span>

#include "estimator/turbidity/sky_samples.hpp"

namespace kasumi::test {

struct CeresSolution {
  double turbidity = 0.0, log_gain = 0.0, cost = 0.0;
};
CeresSolution solve_by_ceres(std::span<const LuminanceSample> samples, std::span<const double> weights, double start);

}  // namespace kasumi::test
