// T from samples of the sky's luminance: the numerical core of the estimate.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "estimator/turbidity/fitted_sky.hpp"
#include "estimator/turbidity/sky_samples.hpp"

namespace kasumi {

struct SolverWindows {
  double narrowest_window = 0.01;  // half width in ln Y: the finest consensus considered
  double widest_window = 0.32;     // and the coarsest
};

struct TurbiditySolution {
  bool solved = false;  // false: fewer than 8 samples, or none agree
  Turbidity turbidity;
  double log_gain = 0.0;      // ln k
  double sigma = 0.0;         // standard deviation of T from the residuals, never below the quantisation's bound
  double log_residual = 0.0;  // root mean square over the inliers
  double model_error = 0.0;   // the part of it not due to quantisation and shot noise (standard deviation)
  int inliers = 0;
  bool at_edge = false;  // the best T is the end of the searched range (for the dome only the hazy end: at the
  // other the sky is as clear as the clearest dome, or clearer)
  std::vector<std::uint8_t> inlier;  // one per sample
};

// Free gain, global, robust. Residual r_i = ln Y_i - ln k - ln F(theta_i, gamma_i; T) (physics 2). Consensus over a
// grid of T (exhaustive, so the result does not depend on chance) with the window's width chosen by the data, then
// graduated non-convexity from there, then weighted least squares over the inliers to the optimum.
TurbiditySolution solve_turbidity(std::span<const LuminanceSample> samples, const SolverWindows& options = {},
                                  const FittedSky& sky = {});

// Weighted least squares in (T, ln k) from a start value, not robust: variable projection of ln k, Gauss-Newton in T.
// `weights` are 1 / variance.
struct LocalSolution {
  Turbidity turbidity;
  double log_gain = 0.0;
  double information = 0.0;  // about T with ln k free: 1 / variance when the weights are right
  double cost = 0.0;         // sum of w r^2
  bool converged = false;
};
LocalSolution refine_turbidity(std::span<const LuminanceSample> samples, std::span<const double> weights,
                               Turbidity start, const FittedSky& sky = {});

}  // namespace kasumi
