// The air of a sky picture by every model of the sky (SkyToFit::every_model): clear air is found without assuming any
// of them; their fits are weighted in estimator/sky_fit.
#pragma once

#include "estimator/turbidity/sky_verdict.hpp"
#include "estimator/turbidity/turbidity.hpp"

namespace kasumi {

// `sky`: of the picture, clouds not marked; afterwards they are (SkyObservation::use). Fills all of the observation but
// what the verdict says: why it is not to be believed; empty: it is.
std::optional<Refusal> observe_by_every_model(SkyObservation& observation, SkyLight sky,
                                              const SkyStatistics& statistics, const SkyPicture& picture,
                                              const SkyGeometry& geometry, const Camera& camera,
                                              const EstimateOptions& options);

// The family that an answer follows: Preetham's, to which T alone belongs, or the dome of the aerosol found.
SkyToFit followed(const SkyFit& fit, SkyToFit sky);

// Directions nearer to the sun are not used.
constexpr Radians kNearestToSun = from_degrees(4.0);

}  // namespace kasumi
