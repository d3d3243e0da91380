// What the land around every pixel of a photograph sends on average, so that a change of the light can tell sun and
// shade.
#pragma once

#include "estimator/photograph/retarget.hpp"

namespace kasumi {

struct LandAroundOptions {
  ScatteringModel scattering = ScatteringModel::morales2017;
  double window = 0.02;  // radius of the surroundings, of the picture's longer side
};

// Mean of L0 / Linf without haze, in windows that follow the picture's edges and those of distance (guided filter);
// what haze hides counts the less. 1 for sky. `light`, `depth`, `air`: as `retarget` takes them.
Image<glm::vec3> land_around(const Image<glm::vec3>& light, const PictureDepth& depth, const PictureAir& air,
                             const AttenuationNodes& nodes, const LandAroundOptions& options = {});

}  // namespace kasumi
