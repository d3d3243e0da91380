// Histogram of residuals.
#pragma once

#include <span>
#include <string>

#include "base/image.hpp"
#include "base/picture.hpp"

namespace kasumi {

// Bars over an axis from 0 to a little more than what 98 % stay below (the rest stands in the last bar), with caption
// under it. Margins of 40 px at the sides and below are inside the given size.
Image<Rgb8> plot_histogram(std::span<const double> sizes, int width, int height, const std::string& caption);

}  // namespace kasumi
