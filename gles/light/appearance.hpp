// Passes light and air to the shaders.
#pragma once

#include <span>

#include "base/result.hpp"
#include "gles/gl/program.hpp"
#include "gles/light/radiance_atlas.hpp"
#include "gles/model/model.hpp"
#include "gles/scene.hpp"

namespace kasumi {

// Checks that values are finite, scale heights and the horizon's light > 0, and physical quantities not negative.
void check(const ObjectAppearance& appearance, Problems& problems);
void check(const SensorNoise& noise, Problems& problems);

// An upper bound of N = rho Gamma + 1 - Gamma for surfaces of albedo <= 1 and these materials, without the sun's glint
// on smooth ones, which is white even when clipped. `sky` holds the light's surroundings.
double largest_n(const ObjectAppearance& appearance, const RadianceAtlas& sky,
                 std::span<const ModelMaterial> materials);

// Uniforms of haze.glsl, path.glsl, sun.glsl, light.glsl; the horizon's light as horizon_light, horizon_place.
void set_appearance(const Program& program, const ObjectAppearance& appearance);

}  // namespace kasumi
