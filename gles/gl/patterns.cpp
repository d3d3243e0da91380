#include "gles/gl/patterns.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "base/units.hpp"
#include "gles/gl/gl.hpp"
#include "gles/gl/texture_units.hpp"

namespace kasumi {
namespace {

// Maps -4 .. 4 to 0 .. 255, symmetric about 0.
std::uint8_t texel_of(double normal) {
  return static_cast<std::uint8_t>(std::clamp(std::floor(normal * 255.0 / 8.0 + 128.0), 0.0, 255.0));
}

// Normal numbers, two at a time (Box and Muller 1958), since the results of std::normal_distribution differ between
// libraries.
std::vector<std::uint8_t> normal_texels(std::size_t count) {
  std::mt19937_64 random(1);
  const auto uniform = [&] { return (static_cast<double>(random() >> 11) + 0.5) * 0x1p-53; };
  std::vector<std::uint8_t> texels;
  while (texels.size() < count) {
    const double radius = std::sqrt(-2.0 * std::log(uniform())), turn = 2.0 * kPi * uniform();
    texels.push_back(texel_of(radius * std::cos(turn)));
    texels.push_back(texel_of(radius * std::sin(turn)));
  }
  texels.resize(count);
  return texels;
}

GlTexture make_pattern(int unit, GLenum format, int size, const std::uint8_t* texels) {
  GlTexture texture = make_texture();
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  glBindTexture(GL_TEXTURE_2D, texture.name());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexImage2D(GL_TEXTURE_2D, 0, static_cast<GLint>(format), size, size, 0, format, GL_UNSIGNED_BYTE, texels);
  set_filter(TextureFilter::nearest);
  return texture;
}

}  // namespace

// Bayer matrix: every 2 x 2, 4 x 4 and 8 x 8 block holds evenly spaced thresholds.
Image<std::uint8_t> dither_texels() {
  Image<std::uint8_t> texels(kDitherSize, kDitherSize);
  for (unsigned y = 0; y < 8; ++y)
    for (unsigned x = 0; x < 8; ++x) {
      unsigned rank = 0;
      for (unsigned bit = 0; bit < 3; ++bit) {
        const unsigned bx = (x >> bit) & 1u, by = (y >> bit) & 1u;
        rank += ((((bx ^ by) << 1u) | by) << (2u * (2u - bit)));
      }
      texels.elements()[8 * y + x] = static_cast<std::uint8_t>(4 * rank + 2);
    }
  return texels;
}

const Image<glm::u8vec3>& noise_texels() {
  static const auto made = [] {
    const auto numbers = normal_texels(std::size_t{3} * kNoiseSize * kNoiseSize);
    Image<glm::u8vec3> texels(kNoiseSize, kNoiseSize);
    for (std::size_t i = 0; i < texels.elements().size(); ++i)
      texels.elements()[i] = {numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]};
    return texels;
  }();
  return made;
}

GlTexture make_dither_pattern() {
  return make_pattern(kDitherUnit, GL_LUMINANCE, kDitherSize, dither_texels().elements().data());
}

GlTexture make_noise_pattern() {
  return make_pattern(kNoiseUnit, GL_RGB, kNoiseSize, &noise_texels().elements().front().x);
}

// Spreads consecutive numbers far apart (the finaliser of SplitMix64).
glm::ivec2 noise_start(std::uint32_t number) {
  std::uint64_t hash = (number + 1) * 0x9E3779B97F4A7C15u;
  hash = (hash ^ (hash >> 30)) * 0xBF58476D1CE4E5B9u;
  hash = (hash ^ (hash >> 27)) * 0x94D049BB133111EBu;
  hash ^= hash >> 31;
  return {static_cast<int>(hash % kNoiseSize), static_cast<int>((hash >> 32) % kNoiseSize)};
}

}  // namespace kasumi
