#include "gles/surface_texture.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "gles/gl.hpp"

namespace kasumi {
namespace {

constexpr GLenum kSrgb8Alpha8 = 0x8C43;  // GLES 3 and EXT_sRGB

double decoded(double code) {
  return code <= 0.04045 ? code / 12.92 : std::pow((code + 0.055) / 1.055, 2.4);
}
double encoded(double light) {
  return light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
}

const std::array<double, 256>& decoding_table() {
  static const std::array<double, 256> table = [] {
    std::array<double, 256> light{};
    for (std::size_t i = 0; i < light.size(); ++i) light[i] = decoded(static_cast<double>(i) / 255.0);
    return light;
  }();
  return table;
}

std::uint8_t byte(double value) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 1.0) * 255.0));
}

// The mean over the area each new texel covers; sizes need not divide.
Image<glm::u8vec4> shrunk(const Image<glm::u8vec4>& picture, int width, int height) {
  const auto& light = decoding_table();
  Image<glm::u8vec4> small(width, height);
  const double step_x = static_cast<double>(picture.width()) / width;
  const double step_y = static_cast<double>(picture.height()) / height;
  const auto share = [](double first, double last, int texel) {
    return std::min(last, texel + 1.0) - std::max(first, static_cast<double>(texel));
  };
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double left = x * step_x, right = left + step_x, top = y * step_y, bottom = top + step_y;
      glm::dvec3 visible{0.0}, any{0.0};
      double alpha = 0.0, area = 0.0;
      for (int v = static_cast<int>(top); v < picture.height() && v < bottom - 1e-9; ++v)
        for (int u = static_cast<int>(left); u < picture.width() && u < right - 1e-9; ++u) {
          const glm::u8vec4 texel = picture.at(u, v);
          const double part = share(left, right, u) * share(top, bottom, v);
          const glm::dvec3 colour{light[texel.r], light[texel.g], light[texel.b]};
          const double opaque = texel.a / 255.0;
          visible += part * opaque * colour;
          any += part * colour;
          alpha += part * opaque;
          area += part;
        }
      const glm::dvec3 colour = alpha > 0.0 ? visible / alpha : any / area;
      small.at(x, y) = {byte(encoded(colour.r)), byte(encoded(colour.g)), byte(encoded(colour.b)), byte(alpha / area)};
    }
  return small;
}

GLint wrap_mode(TextureWrap wrap) {
  switch (wrap) {
    case TextureWrap::clamp: return GL_CLAMP_TO_EDGE;
    case TextureWrap::mirrored_repeat: return GL_MIRRORED_REPEAT;
    case TextureWrap::repeat: break;
  }
  return GL_REPEAT;
}

int power_of_two_within(int size) {
  return static_cast<int>(std::bit_floor(static_cast<unsigned>(size)));
}

}  // namespace

Image<glm::u8vec4> halved(const Image<glm::u8vec4>& picture) {
  return shrunk(picture, std::max(1, picture.width() / 2), std::max(1, picture.height() / 2));
}

Result<SurfaceTexture> upload(const ModelTexture& texture, const GlInfo& info, bool force_encoded,
                              std::vector<std::string>& notes) {
  Image<glm::u8vec4> level = texture.pixels;
  while (level.width() > info.max_texture_size || level.height() > info.max_texture_size) level = halved(level);
  if (info.es_major < 3 && !info.has("GL_OES_texture_npot")) {
    const int width = power_of_two_within(level.width()), height = power_of_two_within(level.height());
    if (width != level.width() || height != level.height()) level = shrunk(level, width, height);
  }
  if (level.width() != texture.pixels.width() || level.height() != texture.pixels.height())
    notes.push_back(fmt::format("texture of {} x {} reduced to {} x {}: the driver takes no larger or other sizes",
                                texture.pixels.width(), texture.pixels.height(), level.width(), level.height()));

  // EXT_sRGB on GLES 2 cannot take mipmaps, so only version 3's sRGB textures serve.
  const bool decodes = !force_encoded && info.es_major >= 3;
  SurfaceTexture made{make_texture(), decodes};
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, made.texture.name());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  for (GLint step = 0;; ++step) {
    glTexImage2D(GL_TEXTURE_2D, step, decodes ? static_cast<GLint>(kSrgb8Alpha8) : GL_RGBA, level.width(),
                 level.height(), 0, GL_RGBA, GL_UNSIGNED_BYTE, level.elements().data());
    if (level.width() == 1 && level.height() == 1) break;
    level = halved(level);
  }
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, texture.nearest ? GL_NEAREST : GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, wrap_mode(texture.wrap_s));
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, wrap_mode(texture.wrap_t));
  if (auto uploaded = check_gl("uploading a texture of the model"); !uploaded) return tl::unexpected(uploaded.error());
  return made;
}

}  // namespace kasumi
