// A plot of how well the sky model fits a photograph.
#pragma once

#include <string>

#include "base/image.hpp"
#include "base/picture.hpp"
#include "estimator/turbidity/turbidity.hpp"

namespace kasumi {

// Left: the sky with its samples (green: agree with the model, red: do not; blue tint: taken for cloud). Right:
// measured against modelled luminance of the samples, in units of the zenith, with the line they should lie on.
Image<Rgb8> plot_fit(const SkyPicture& picture, const TurbidityObservation& observation, const std::string& title);

}  // namespace kasumi
