// A model for a camera that sees it from afar: what is finer than the camera's pixels is taken out of it.
#pragma once

#include <vector>

#include "base/result.hpp"
#include "gles/model/model.hpp"

namespace kasumi {

// Lengths in the model's units.
struct Coarseness {
  double error = 0.0;   // by which surfaces may move; 0: they stay
  double relief = 0.0;  // finer than this it is seen as a whole: its vertices take their mean normal before
  double texel = 0.0;   // no texel that is left covers more of a surface; 0: textures stay
};

// `scenes`: one or more of one file, so with the same materials and textures, whose levels are made (mip_levels.hpp): a
// smaller texture is one of them. The ground stays. Surfaces by libmeshoptimizer (Garland and Heckbert's quadrics), which
// keeps some of the vertices as they are: where triangles are smaller than `relief`, each would stand for a slope that no
// pixel sees by itself. Errors: unsupported (the module is not there).
Result<std::vector<Model>> coarser(std::vector<Model> scenes, const Coarseness& coarseness);

}  // namespace kasumi
