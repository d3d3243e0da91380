// The sky that a fitted model stands for.
#pragma once

#include <functional>

#include <glm/vec3.hpp>

#include "estimator/sky/site_sky.hpp"
#include "estimator/sky_fit/sky_fit.hpp"

namespace kasumi {

// Linear sRGB from a direction above the horizon, in a unit of the model's own. `sky`: as it was given to fit_sky().
std::function<glm::dvec3(const Direction&)> light_of(const ModelFit& model, const SunDirection& sun,
                                                     const ModelToFit& sky);

}  // namespace kasumi
