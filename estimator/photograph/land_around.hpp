// The mean light of the land around every pixel of a photograph, by which relighting separates sun from shade.
#pragma once

#include "estimator/photograph/retarget.hpp"

namespace kasumi {

struct LandAroundParameters {
  ScatteringModel scattering = ScatteringModel::morales2017;
  double window = 0.02;  // radius of the surroundings, of the picture's longer side
};

// Mean of L0 / Linf without haze, in windows that follow the edges of the picture and of distance (guided filter); the
// more haze, the lower the weight. 1 for sky. `light`, `depth`, `air`: as for `retarget`.
Image<glm::vec3> land_around(const Image<glm::vec3>& light, const RetargetGeometry& depth, const RetargetAir& air,
                             const AttenuationNodes& nodes, const LandAroundParameters& options = {});

}  // namespace kasumi
