#include "gles/composite/foreground.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <glm/gtc/type_precision.hpp>

#include "gles/gl/gl.hpp"
#include "gles/gl/texture_units.hpp"

namespace kasumi {
namespace {

// A mask that falls from free to covered within a pixel or two shows a still edge, and its shares are those of the
// pixels; where it falls slowly, something moves, and they are a mean over time.
std::uint8_t trust_in(const Image<std::uint8_t>& mask, int x, int y) {
  // Of 255: a still edge falls by nearly all of its range within two pixels.
  constexpr int kMoves = 215, kStill = 255, kMost = 255;
  int low = 255, high = 0;
  for (int v = std::max(0, y - 1); v <= std::min(mask.height() - 1, y + 1); ++v)
    for (int u = std::max(0, x - 1); u <= std::min(mask.width() - 1, x + 1); ++u) {
      low = std::min<int>(low, mask.at(u, v));
      high = std::max<int>(high, mask.at(u, v));
    }
  return static_cast<std::uint8_t>(std::clamp((high - low - kMoves) * kMost / (kStill - kMoves), 0, kMost));
}

// Marks the pixels up to `reach` away from where the mask changes.
Image<std::uint8_t> near_edges(const Image<std::uint8_t>& mask, int reach) {
  Image<std::uint8_t> near(mask.width(), mask.height(), 0);
  for (int y = 0; y < mask.height(); ++y)
    for (int x = 0; x < mask.width(); ++x) {
      const bool changes = (x + 1 < mask.width() && mask.at(x + 1, y) != mask.at(x, y)) ||
                           (y + 1 < mask.height() && mask.at(x, y + 1) != mask.at(x, y));
      if (!changes) continue;
      for (int v = std::max(0, y - reach); v <= std::min(mask.height() - 1, y + 1 + reach); ++v)
        for (int u = std::max(0, x - reach); u <= std::min(mask.width() - 1, x + 1 + reach); ++u) near.at(u, v) = 1;
    }
  return near;
}

// Weights of a Gaussian's pixels from its middle outwards, whose sum over both sides is 1.
std::vector<double> gaussian(double sigma_px) {
  std::vector<double> weights;
  const int reach = static_cast<int>(std::ceil(3.0 * sigma_px));
  double sum = 0.0;
  for (int i = 0; i <= reach; ++i) {
    weights.push_back(std::exp(-0.5 * i * i / (sigma_px * sigma_px)));
    sum += (i > 0 ? 2.0 : 1.0) * weights.back();
  }
  for (double& weight : weights) weight /= sum;
  return weights;
}

// What a camera's point spread makes of a mask near its edges: the free shares and their confidence, which is that of
// the most certain edge mixed into a pixel. One pass along rows, one along columns.
class SpreadMask {
 public:
  SpreadMask(const Image<std::uint8_t>& mask, const Image<std::uint8_t>& trust, std::vector<double> weights)
      : weights_(std::move(weights)), sums_(mask.width(), mask.height()), most_(mask.width(), mask.height()) {
    const auto needed = near_edges(mask, 2 * reach());
    for (int y = 0; y < mask.height(); ++y)
      for (int x = 0; x < mask.width(); ++x)
        if (needed.at(x, y))
          gather(
              mask, trust, [&](int u) { return glm::ivec2(std::clamp(x + u, 0, mask.width() - 1), y); }, sums_.at(x, y),
              most_.at(x, y));
  }
  // Within reach() of an edge.
  glm::u8vec2 at(int x, int y) const {
    float sum = 0.0F;
    std::uint8_t most = 0;
    gather(
        sums_, most_, [&](int v) { return glm::ivec2(x, std::clamp(y + v, 0, sums_.height() - 1)); }, sum, most);
    return {static_cast<std::uint8_t>(std::lround(sum)), most};
  }
  int reach() const { return static_cast<int>(weights_.size()) - 1; }

 private:
  template <class Value, class Place>
  void gather(const Image<Value>& values, const Image<std::uint8_t>& trust, Place place, float& sum,
              std::uint8_t& most) const {
    double all = 0.0;
    most = 0;
    for (int i = -reach(); i <= reach(); ++i) {
      const glm::ivec2 there = place(i);
      all += weights_[static_cast<std::size_t>(std::abs(i))] * static_cast<double>(values.at(there.x, there.y));
      most = std::max(most, trust.at(there.x, there.y));
    }
    sum = static_cast<float>(all);
  }

  std::vector<double> weights_;
  Image<float> sums_;  // along rows
  Image<std::uint8_t> most_;
};

}  // namespace

Result<Foreground> Foreground::upload(const Image<std::uint8_t>& mask, double point_spread_px, const GlInfo& info) {
  if (mask.width() > info.max_texture_size || mask.height() > info.max_texture_size)
    return fail(FaultKind::bad_input, "foreground mask of {} x {} pixels: this driver supports at most {}",
                mask.width(), mask.height(), info.max_texture_size);
  Foreground made;
  made.mask_ = mask;
  auto weights = point_spread_px > 0.0 ? gaussian(point_spread_px) : std::vector<double>{1.0};
  const auto edges = near_edges(mask, static_cast<int>(weights.size()) - 1);
  Image<std::uint8_t> trust(mask.width(), mask.height(), 0);
  for (int y = 0; y < mask.height(); ++y)
    for (int x = 0; x < mask.width(); ++x)
      if (edges.at(x, y) || made.is_mixed(x, y)) trust.at(x, y) = trust_in(mask, x, y);
  const SpreadMask spread(mask, trust, std::move(weights));
  Image<glm::u8vec2> texels(mask.width(), mask.height());
  for (int y = 0; y < mask.height(); ++y)
    for (int x = 0; x < mask.width(); ++x) {
      texels.at(x, y) = edges.at(x, y) ? spread.at(x, y) : glm::u8vec2{mask.at(x, y), trust.at(x, y)};
    }
  for (std::size_t i = 0; i < texels.elements().size(); ++i) made.mask_.elements()[i] = texels.elements()[i].x;
  made.texture_ = make_texture();
  made.bind();
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_LUMINANCE_ALPHA, mask.width(), mask.height(), 0, GL_LUMINANCE_ALPHA,
               GL_UNSIGNED_BYTE, texels.elements().data());
  made.texels_ = std::move(texels);
  set_filter(TextureFilter::nearest);
  clamp_to_edge();
  if (auto uploaded = check_gl("uploading the foreground mask"); !uploaded) return fail(uploaded.error());
  return made;
}

void Foreground::bind() const {
  glActiveTexture(GL_TEXTURE0 + kForegroundUnit);
  glBindTexture(GL_TEXTURE_2D, texture_.name());
}

}  // namespace kasumi
