// T of a sky picture by one model of the sky, which is believed: by its luminance alone.
#pragma once

#include "estimator/turbidity/sky_verdict.hpp"
#include "estimator/turbidity/turbidity.hpp"

namespace kasumi {

// `sky`: of the picture, clouds not marked; afterwards they are (SkyObservation::use). Fills all of the observation but
// what the verdict says: why it is not to be believed; empty: it is.
std::optional<Refusal> observe_by_one_model(SkyObservation& observation, SkyLight sky, const SkyStatistics& statistics,
                                            const SkyPicture& picture, const SkyGeometry& geometry,
                                            const Camera& camera, const EstimateOptions& options);

}  // namespace kasumi
