// The colours of a clear sky paired with the spectra its light must have, from which a camera's sensitivity is found.
#pragma once

#include <vector>

#include "calib/colour/sensitivity_fit.hpp"
#include "estimator/turbidity/turbidity.hpp"

namespace kasumi {

// Cells of about 6 by 6 deg of the sky that `observation` classified as clear: mean log ratios of the camera's linear
// light (vignetting removed, white balance not), and the mean daylight weights of Preetham's chromaticities for this T
// and sun. `number` is the picture's.
std::vector<DaylightColour> sky_colours(const SkyPicture& picture, const TurbidityObservation& observation,
                                        const Camera& camera, Turbidity turbidity, int number);

}  // namespace kasumi
