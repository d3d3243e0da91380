// Cloud or clear, asked of the sky as it is: clear air is smooth around its sun, whatever its aerosol; no sky model is
// consulted.
#pragma once

#include "estimator/turbidity/sky_samples.hpp"

namespace kasumi {

struct SmoothAureole {
  Image<PixelUse> use;         // PixelUse::clear where `use` said cloud, but the sky is as smooth there as clear air
  double uncovered_sun = 0.0;  // 0..1: certainty that the aureole is undisturbed up to the sun's own place
};

// `use`: clouds marked by their difference from a clear sky's model (TurbidityObservation::use). In air of other aerosols
// than the model's the aureole differs from it as a cloud does, but a cloud has texture, edges and a colour of its own,
// and the aureole has none of these.
SmoothAureole smooth_aureole(const SkyPicture& picture, const ElementGeometry& geometry, const Camera& camera,
                             const Image<PixelUse>& use, const SunDirection& sun);

}  // namespace kasumi
