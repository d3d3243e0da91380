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

// The least of 0 .. `most` whose `share` is at least that wanted, which grows with it.
template <class Share>
std::size_t least_of(std::size_t most, double wanted, Share share) {
  std::size_t low = 0, high = most;
  while (low < high) {
    const std::size_t middle = low + (high - low) / 2;
    if (share(middle) < wanted)
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

// Scales a smaller level's alpha until the cutoff leaves the same share as in the full picture. If the texels are too
// alike for that, lets as many of the most opaque ones stand as leave that share, with ties broken pseudo-randomly.
void keep_share(Image<glm::u8vec4>& level, double cutoff, double share) {
  constexpr double kNear = 0.05;  // of what is kept or cut out: wires that cover little must not vanish
  constexpr double kSteps = 1 << 16, kMostScale = 16.0;
  const std::vector<glm::u8vec4> before = level.elements();
  const auto off = [&] { return std::abs(share_above(level, cutoff) - share); };
  const auto scale = kMostScale / kSteps *
                     static_cast<double>(least_of(static_cast<std::size_t>(kSteps), share, [&](std::size_t step) {
                       return share_above(level, cutoff, kMostScale / kSteps * static_cast<double>(step));
                     }));
  for (glm::u8vec4& texel : level.elements()) texel.a = byte(scale * texel.a / 255.0);
  const double off_scaled = off();
  if (off_scaled <= kNear * std::min(share, 1.0 - share)) return;
  std::vector<std::size_t> order(before.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::sort(order, std::greater<>(), [&](std::size_t i) {
    return std::pair(before[i].a, static_cast<std::uint32_t>(i + 1) * 2654435761u);  // Knuth's mixing
  });
  const auto scaled = level.elements();
  const auto let_stand = [&](std::size_t standing) {
    for (std::size_t i = 0; i < order.size(); ++i) level.elements()[order[i]].a = i < standing ? 255 : 0;
  };
  const std::size_t enough = least_of(order.size(), share, [&](std::size_t standing) {
    let_stand(standing);
    return share_above(level, cutoff);
  });
  let_stand(enough);
  if (const double off_above = off(); enough > 0) {
    let_stand(enough - 1);
    if (off() > off_above) let_stand(enough);
  }
  if (off() > off_scaled) level.elements() = scaled;
}

void keep_shares(const Image<glm::u8vec4>& picture, double cutoff, std::vector<Image<glm::u8vec4>>& smaller) {
  const double share = share_above(picture, cutoff);
  for (auto& level : smaller) keep_share(level, cutoff, share);
}

std::vector<Image<glm::u8vec4>> halvings(const Image<glm::u8vec4>& picture, bool data) {
  std::vector<Image<glm::u8vec4>> levels;
  for (const auto* last = &picture; last->width() > 1 || last->height() > 1; last = &levels.back())
    levels.push_back(halved(*last, data));
  return levels;
}

// How the model's materials use a texture's alpha.
struct AlphaUse {
  bool shown = false, ignored = false;
};
AlphaUse alpha_use(const Model& model, int texture) {
  AlphaUse use;
  for (const ModelMaterial& material : model.materials) {
    if (material.texture == texture) (material.alpha == ModelMaterial::Alpha::opaque ? use.ignored : use.shown) = true;
    use.ignored = use.ignored || material.emission_map.texture == texture;
  }
  return use;
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
      if (alpha > 0.0 && !data) small.at(x, y).a = std::max<std::uint8_t>(small.at(x, y).a, 1);  // it has a colour
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
  auto levels = halvings(picture, data);
  if (cutoff) keep_shares(picture, *cutoff, levels);
  return levels;
}

void spread_visible_colours(Image<glm::u8vec4>& picture, std::vector<Image<glm::u8vec4>>& smaller) {
  for (std::size_t level = smaller.size(); level-- > 0;) {
    Image<glm::u8vec4>& finer = level > 0 ? smaller[level - 1] : picture;
    const Image<glm::u8vec4>& coarser = smaller[level];
    for (int y = 0; y < finer.height(); ++y)
      for (int x = 0; x < finer.width(); ++x) {
        glm::u8vec4& texel = finer.at(x, y);
        if (texel.a == 0)
          texel = glm::u8vec4(
              glm::u8vec3(coarser.at(std::min(x / 2, coarser.width() - 1), std::min(y / 2, coarser.height() - 1))), 0);
      }
  }
}

void make_levels(Model& model) {
  for (std::size_t i = 0; i < model.textures.size(); ++i) {
    ModelTexture& texture = model.textures[i];
    const AlphaUse use = alpha_use(model, static_cast<int>(i));
    if (!texture.data && !use.shown)
      for (glm::u8vec4& texel : texture.pixels.elements()) texel.a = 255;
    texture.smaller = halvings(texture.pixels, texture.data);
    if (!texture.data && use.shown && !use.ignored) spread_visible_colours(texture.pixels, texture.smaller);
    if (const auto cutoff = cutoff_of(model, static_cast<int>(i)))
      keep_shares(texture.pixels, *cutoff, texture.smaller);
  }
}

}  // namespace kasumi
