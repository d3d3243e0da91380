// The sky's light and colour by a picture's clear elements, as input of the fit (estimator/sky_fit).
#pragma once

#include <span>
#include <vector>

#include "estimator/sky_fit/sky_fit.hpp"
#include "estimator/turbidity/sky_samples.hpp"

namespace kasumi {

struct ElementReadings {
  std::vector<SkyReading> readings;
  std::vector<glm::ivec2> elements;  // one per reading
};

// Means over the clear ones of 3 x 3 elements around each of `elements`; left out where a colour is not above 0.
ElementReadings readings_at(std::span<const glm::ivec2> elements, const SkyPicture& picture,
                            const ElementGeometry& geometry, const ElementLight& sky, const Camera& camera,
                            const SunDirection& sun, const SampleLimits& limits);

// How uncertain this camera is: measured colours are more certain than an automatic white balance, and measured
// vignetting more certain than a lens's usual one.
InstrumentDoubt doubt_of(const Camera& camera);

}  // namespace kasumi
