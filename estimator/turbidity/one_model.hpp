// T of a sky picture by one model of the sky, which is believed: by its luminance alone.
#pragma once

#include "estimator/turbidity/sky_verdict.hpp"
#include "estimator/turbidity/turbidity.hpp"

namespace kasumi {

// `sky`: of the picture, clouds not marked; afterwards they are (TurbidityObservation::use). Fills all of the observation but
// what the verdict says: why it is not to be believed; empty: it is.
std::optional<Refusal> observe_by_one_model(TurbidityObservation& observation, ElementLight sky,
                                            const ExposureStatistics& statistics, const SkyPicture& picture,
                                            const ElementGeometry& geometry, const Camera& camera,
                                            const EstimateParameters& options);

}  // namespace kasumi
