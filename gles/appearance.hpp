// Light and air on their way to the shaders.
#pragma once

#include "base/result.hpp"
#include "gles/program.hpp"
#include "gles/renderer.hpp"

namespace kasumi {

// Everything finite, scale heights and the horizon's light > 0, nothing negative that cannot be.
void check(const ObjectAppearance& appearance, Problems& problems);

// An upper bound of N = rho Gamma + 1 - Gamma for surfaces of albedo <= 1.
double largest_n(const ObjectAppearance& appearance);

// Uniforms of haze.glsl, path.glsl, object.frag; the horizon's light as horizon_light, horizon_place.
void set_appearance(const Program& program, const ObjectAppearance& appearance);

}  // namespace kasumi
