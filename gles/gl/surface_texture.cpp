#include "gles/gl/surface_texture.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <functional>
#include <utility>

#include "gles/gl/gl.hpp"

namespace kasumi {
namespace {

constexpr GLenum kSrgb8Alpha8 = 0x8C43;                                    // GLES 3 and EXT_sRGB
constexpr GLenum kMaxAnisotropy = 0x84FF, kTextureMaxAnisotropy = 0x84FE;  // EXT_texture_filter_anisotropic

double decoded(double code) {
  return code <= 0.04045 ? code / 12.92 : std::pow((code + 0.055) / 1.055, 2.4);
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

// The nearest code: the first whose upper bound is not below the light. Twice as fast as pow.
std::uint8_t encoded(double light) {
  static const std::array<double, 255> ends = [] {
    std::array<double, 255> made{};
    for (std::size_t i = 0; i < made.size(); ++i) made[i] = decoded((static_cast<double>(i) + 0.5) / 255.0);
    return made;
  }();
  return static_cast<std::uint8_t>(std::ranges::upper_bound(ends, light) - ends.begin());
}

// The mean over the area each new texel covers; sizes need not be multiples.
Image<glm::u8vec4> shrunk(const Image<glm::u8vec4>& picture, int width, int height, bool data) {
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
          const glm::dvec3 colour =
              data ? glm::dvec3(texel) / 255.0 : glm::dvec3{light[texel.r], light[texel.g], light[texel.b]};
          const double opaque = texel.a / 255.0;
          visible += part * opaque * colour;
          any += part * colour;
          alpha += part * opaque;
          area += part;
        }
      const glm::dvec3 colour = alpha > 0.0 && !data ? visible / alpha : any / area;
      for (int c = 0; c < 3; ++c) small.at(x, y)[c] = data ? byte(colour[c]) : encoded(colour[c]);
      small.at(x, y).a = byte(alpha / area);
    }
  return small;
}

// Scales a smaller level's alpha until the cutoff leaves the same share as in the full picture. If the texels are too
// alike for that, keeps that share of the most opaque ones, with ties broken pseudo-randomly.
void keep_share(Image<glm::u8vec4>& level, double cutoff, double share) {
  double low = 0.0, high = 16.0;
  for (int i = 0; i < 20; ++i) {
    const double middle = 0.5 * (low + high);
    (share_above(level, cutoff, middle) < share ? low : high) = middle;
  }
  const double scale = 0.5 * (low + high);
  constexpr double kNear = 0.1;
  if (std::abs(share_above(level, cutoff, scale) - share) < kNear) {
    for (glm::u8vec4& texel : level.elements()) texel.a = byte(scale * texel.a / 255.0);
    return;
  }
  std::vector<std::size_t> order(level.elements().size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::sort(order, std::greater<>(), [&](std::size_t i) {
    return std::pair(level.elements()[i].a, static_cast<std::uint32_t>(i + 1) * 2654435761u);  // Knuth's mixing
  });
  const auto standing = static_cast<std::size_t>(std::lround(share * static_cast<double>(order.size())));
  for (std::size_t i = 0; i < order.size(); ++i) level.elements()[order[i]].a = i < standing ? 255 : 0;
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

Image<glm::u8vec4> halved(const Image<glm::u8vec4>& picture, bool data) {
  return shrunk(picture, std::max(1, picture.width() / 2), std::max(1, picture.height() / 2), data);
}

double share_above(const Image<glm::u8vec4>& picture, double cutoff, double alpha_scale) {
  constexpr int kSteps = 4;  // samples per texel, since small levels need parts of texels
  const auto alpha = [&](int x, int y) {
    return std::min(1.0, alpha_scale * picture.at(x % picture.width(), y % picture.height()).a / 255.0);
  };
  std::size_t above = 0;
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x) {
      const double a = alpha(x, y), b = alpha(x + 1, y), c = alpha(x, y + 1), d = alpha(x + 1, y + 1);
      for (int v = 0; v < kSteps; ++v)
        for (int u = 0; u < kSteps; ++u) {
          const double s = (u + 0.5) / kSteps, t = (v + 0.5) / kSteps;
          if ((a * (1 - s) + b * s) * (1 - t) + (c * (1 - s) + d * s) * t >= cutoff) ++above;
        }
    }
  return static_cast<double>(above) / (kSteps * kSteps) / static_cast<double>(picture.elements().size());
}

std::optional<double> cutoff_of(const Model& model, int texture) {
  std::optional<double> lowest;
  for (const ModelMaterial& material : model.materials) {
    if (material.texture != texture || material.alpha != ModelMaterial::Alpha::mask) continue;
    const double cutoff = double(material.alpha_cutoff) / std::max(double(material.base_colour.a), 1e-3);
    lowest = std::min(lowest.value_or(cutoff), cutoff);
  }
  return lowest;
}

Result<SurfaceTexture> upload(const ModelTexture& texture, std::optional<double> cutoff, const GlInfo& info,
                              bool force_encoded, std::vector<std::string>& notes) {
  Image<glm::u8vec4> level = texture.pixels;
  while (level.width() > info.max_texture_size || level.height() > info.max_texture_size)
    level = halved(level, texture.data);
  if (info.es_major < 3 && !info.has("GL_OES_texture_npot")) {
    const int width = power_of_two_within(level.width()), height = power_of_two_within(level.height());
    if (width != level.width() || height != level.height()) level = shrunk(level, width, height, texture.data);
  }
  if (level.width() != texture.pixels.width() || level.height() != texture.pixels.height())
    notes.push_back(fmt::format("texture of {} x {} reduced to {} x {}, a size that the driver supports",
                                texture.pixels.width(), texture.pixels.height(), level.width(), level.height()));

  // EXT_sRGB on GLES 2 does not support mipmaps, so only version 3's sRGB textures are used.
  const bool decodes = !force_encoded && info.es_major >= 3 && !texture.data;
  SurfaceTexture made{make_texture(), decodes, texture.data};
  const double share = cutoff ? share_above(level, *cutoff) : 1.0;
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, made.texture.name());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  for (GLint step = 0;; ++step) {
    glTexImage2D(GL_TEXTURE_2D, step, decodes ? static_cast<GLint>(kSrgb8Alpha8) : GL_RGBA, level.width(),
                 level.height(), 0, GL_RGBA, GL_UNSIGNED_BYTE, level.elements().data());
    made.bytes += level.elements().size() * sizeof(glm::u8vec4);
    if (level.width() == 1 && level.height() == 1) break;
    level = halved(level, texture.data);
    if (cutoff) keep_share(level, *cutoff, share);
  }
  if (!info.software && info.has("GL_EXT_texture_filter_anisotropic")) {  // software drivers blur and are slow at it
    constexpr GLfloat kMaxUsefulAnisotropy =
        8.0f;  // enough for roofs and courtyards seen at a few degrees; the layer adds 17 samples per pixel
    GLfloat most = 1.0f;
    glGetFloatv(kMaxAnisotropy, &most);
    glTexParameterf(GL_TEXTURE_2D, kTextureMaxAnisotropy, std::min(most, kMaxUsefulAnisotropy));
  }
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, texture.nearest ? GL_NEAREST : GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, wrap_mode(texture.wrap_s));
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, wrap_mode(texture.wrap_t));
  if (auto uploaded = check_gl("uploading a texture of the model"); !uploaded) return fail(uploaded.error());
  return made;
}

}  // namespace kasumi
