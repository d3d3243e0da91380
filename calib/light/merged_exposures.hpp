// Exposures of one sky, taken within seconds, as one picture.
#pragma once

#include <optional>
#include <vector>

#include "base/photograph.hpp"
#include "calib/light/radiometry.hpp"

namespace kasumi {

struct MergedExposures {
  Photograph picture;          // exposed so that the sky just is not saturated, as far as the exposures reach
  std::vector<double> ratios;  // light of each to that of the shortest, in the order given
};

// By the light of `response`, or of sRGB to any power: the exposures' ratios are found in the pictures, and each pixel
// is the mean of those in which it is neither saturated nor dark, weighted by exposure. Empty: no exposure is 1.25 times
// another, sizes differ, or neighbours in brightness are no multiples of each other (clouds that moved, another view).
std::optional<MergedExposures> merge_exposures(const std::vector<Photograph>& exposures, const Response& response);

}  // namespace kasumi
