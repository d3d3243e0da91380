// The air of a sky picture by every model of the sky (ModelToFit::every_model): clear air is found without assuming any
// of them; their fits are weighted in estimator/sky_fit.
#pragma once

#include "estimator/turbidity/sky_verdict.hpp"
#include "estimator/turbidity/turbidity.hpp"

namespace kasumi {

// `sky`: of the picture, clouds not marked; afterwards they are (TurbidityObservation::use). Fills all of the observation but
// what the verdict says: why it is not to be believed; empty: it is.
std::optional<Refusal> observe_by_every_model(TurbidityObservation& observation, ElementLight sky,
                                              const ExposureStatistics& statistics, const SkyPicture& picture,
                                              const ElementGeometry& geometry, const Camera& camera,
                                              const EstimateParameters& options);

// The family that an answer follows: Preetham's, to which T alone belongs, or the dome of the aerosol found.
ModelToFit followed(const SkyFit& fit, ModelToFit sky);

// Directions nearer to the sun are not used.
constexpr Radians kNearestToSun = from_degrees(4.0);

}  // namespace kasumi
