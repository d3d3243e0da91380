// Outlier rejection: finds sights that contradict the others.
#pragma once

#include <vector>

#include "calib/pose/pose_fit.hpp"

namespace kasumi {

// chi^2 of the sights used, and what it would be on average with honest sigmas.
struct PoseMisfit {
  double chi2 = 0.0, expected = 0.0;
};
PoseMisfit misfit_of(const PoseFit& fit, const std::vector<bool>& used);

// How far a sight contradicts the others, squared and in units of its expectation, ignoring directions in which nothing
// checks it. `least_checked`: the smallest part of an error that the others would reveal.
struct Contradiction {
  double squared = 0.0;
  double least_checked = 1.0;
};
Contradiction contradiction(const PoseFit& fit, std::size_t sight, bool used);

// Drops what the rest contradicts, the worst first, and restores those that agree after all (Baarda's data snooping).
// `used`: to begin with, and then in the end.
PoseFit fit_without_wrong(const PoseParameters& from, const ScaledLens& lens, const ScenePrior& prior,
                          const PoseSights& sights, std::vector<bool>& used);

}  // namespace kasumi
