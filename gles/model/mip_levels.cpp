#include "gles/model/mip_levels.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <utility>

namespace kasumi {
namespace {

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

}  // namespace

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

std::vector<Image<glm::u8vec4>> smaller_levels(const Image<glm::u8vec4>& picture, bool data,
                                               std::optional<double> cutoff) {
  std::vector<Image<glm::u8vec4>> levels;
  const double share = cutoff ? share_above(picture, *cutoff) : 1.0;
  for (const auto* last = &picture; last->width() > 1 || last->height() > 1; last = &levels.back()) {
    levels.push_back(halved(*last, data));
    if (cutoff) keep_share(levels.back(), *cutoff, share);
  }
  return levels;
}

void make_levels(Model& model) {
  for (std::size_t i = 0; i < model.textures.size(); ++i) {
    ModelTexture& texture = model.textures[i];
    texture.smaller = smaller_levels(texture.pixels, texture.data, cutoff_of(model, static_cast<int>(i)));
  }
}

}  // namespace kasumi
