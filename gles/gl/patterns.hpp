// Small textures that fine steps of light are spread over: an even one against banding, a random one for noise.
#pragma once

#include <cstdint>

#include <glm/vec2.hpp>

#include "gles/gl/objects.hpp"

namespace kasumi {

// 8 x 8, for dither.glsl.
GlTexture make_dither_pattern();

// Normally distributed, mean 0 and variance 1 in each channel, from -4 to 4, for noise.glsl. Repeats itself.
constexpr int kNoiseSize = 512;
GlTexture make_noise_pattern();
// Where the pattern of that number begins, in texels.
glm::ivec2 noise_start(std::uint32_t number);

}  // namespace kasumi
