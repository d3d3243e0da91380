// A clear sky seen by a camera of which nothing was measured. Its tone curve and the light it loses towards the rim are
// unknowns beside the air, each with a prior; the air's sigma is what stays uncertain with all of them.
#pragma once

#include <span>

#include "estimator/sky_fit/camera_belief.hpp"
#include "estimator/sky_fit/sky_fit.hpp"

namespace kasumi {

struct UncalibratedFit {
  SkyFit sky;
  double exponent = 1.0, sigma_exponent = 0.0;  // the tone exponent of this picture and the prior
  double rim_loss = 0.0, sigma_rim_loss = 0.0;  // of ln light at the rim, as this picture and the prior have it
  double log_residual = 0.0;                    // that the best of all leaves
};

// `readings`: of clear sky alone, with the light that the supposed response gives; some hundred. `sky`: the site's
// altitude, the models to fit, and what is given of the air.
UncalibratedFit fit_unknown_camera(std::span<const SkyReading> readings, const SunDirection& sun, const ModelToFit& sky,
                                   const CameraBelief& belief = {});

}  // namespace kasumi
