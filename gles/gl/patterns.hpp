// Small pattern textures: an ordered one for dithering, a random one for noise.
#pragma once

#include <cstdint>

#include <glm/gtc/type_precision.hpp>
#include <glm/vec2.hpp>

#include "base/image.hpp"
#include "gles/gl/objects.hpp"

namespace kasumi {

// For dither.glsl.
constexpr int kDitherSize = 8;
Image<std::uint8_t> dither_texels();
GlTexture make_dither_pattern();

// Normally distributed, mean 0 and variance 1 in each channel, from -4 to 4, for noise.glsl. Tiles.
constexpr int kNoiseSize = 512;
const Image<glm::u8vec3>& noise_texels();  // made once
GlTexture make_noise_pattern();
// Offset of the pattern with that number, in texels.
glm::ivec2 noise_start(std::uint32_t number);

}  // namespace kasumi
