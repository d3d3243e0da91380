// Small pattern textures: an ordered one for dithering, a random one for noise.
#pragma once

#include <cstdint>

#include <glm/vec2.hpp>

#include "gles/gl/objects.hpp"

namespace kasumi {

// 8 x 8, for dither.glsl.
GlTexture make_dither_pattern();

// Normally distributed, mean 0 and variance 1 in each channel, from -4 to 4, for noise.glsl. Tiles.
constexpr int kNoiseSize = 512;
GlTexture make_noise_pattern();
// Offset of the pattern with that number, in texels.
glm::ivec2 noise_start(std::uint32_t number);

}  // namespace kasumi
