#include "estimator/haze_passes.hpp"

#include <algorithm>
#include <cmath>

#include "estimator/haze_range.hpp"

namespace kasumi {
namespace {

// A picture's pixel -1 is its pixel 0 again.
int mirrored(int at, int size) {
  if (at < 0) at = -1 - at;
  return at < size ? at : 2 * size - 1 - at;
}

// 1 on one surface, 0 on two.
float joined(float sum, float other) {
  float apart = std::abs(sum - other);
  apart = std::min(apart, kRangeStepTurn - apart);
  const float t = std::clamp((kOtherSurface - apart) / (kOtherSurface - kSameSurface), 0.0F, 1.0F);
  return t * t * (3.0F - 2.0F * t);
}

}  // namespace

// `between(rates of one row, of another, steps' sums of both, pixel in the one, in the other)`.
template <class Between>
void Conductances::set(int offset_px, Between between) {
  const int width = rate_.width(), height = rate_.height(), d = offset_px;
  for (int y = 0; y < height; ++y) {
    float *right = right_.row(y), *left = left_of_edge_.row(y);
    const auto in_row = between(rate_.row(y), rate_.row(y), y, y, true);
    for (int x = 0; x < width - d; ++x) right[x] = in_row(x, x + d);
    for (int x = std::max(width - d, 0); x < width; ++x) right[x] = in_row(x, mirrored(x + d, width));
    for (int x = 0; x < std::min(d, width); ++x) left[x] = in_row(x, mirrored(x - d, width));
    const int below = mirrored(y + d, height);
    const auto to_below = between(rate_.row(y), rate_.row(below), y, below, false);
    float* down = down_.row(y);
    for (int x = 0; x < width; ++x) down[x] = to_below(x, x);
    if (y >= d) continue;
    const int above = mirrored(y - d, height);
    const auto to_above = between(rate_.row(y), rate_.row(above), y, above, false);
    for (int x = 0; x < width; ++x) above_edge_.at(x, y) = to_above(x, x);
  }
}

void Conductances::set_means(const Image<float>& rate) {
  rate_ = rate;
  set(1, [](const float* one, const float* other, int, int, bool) {
    return [=](int x, int ox) { return 0.5F * (one[x] + other[ox]); };
  });
}

void Conductances::set_matched(const MatchedPass& pass, const Image<float>& wanted_px2,
                               const Image<float>& steps_along_row, const Image<float>& steps_down_column) {
  const auto from = static_cast<float>(pass.from_px2), most = static_cast<float>(pass.variance_px2);
  const auto per_variance = static_cast<float>(0.5 / (static_cast<double>(pass.offset_px) * pass.offset_px));
  std::ranges::transform(wanted_px2.elements(), rate_.elements().begin(),
                         [&](float wanted) { return per_variance * std::min(std::max(wanted - from, 0.0F), most); });
  if (steps_along_row.empty() || steps_down_column.empty()) {
    set(pass.offset_px, [](const float* one, const float* other, int, int, bool) {
      return [=](int x, int ox) { return std::min(one[x], other[ox]); };
    });
    return;
  }
  set(pass.offset_px, [&](const float* one, const float* other, int y, int other_y, bool along_row) {
    const auto& steps = along_row ? steps_along_row : steps_down_column;
    const float *sum = steps.row(y), *other_sum = steps.row(other_y);
    return [=](int x, int ox) { return std::min(one[x], other[ox]) * joined(sum[x], other_sum[ox]); };
  });
}

void symmetric_pass(const Image<glm::vec4>& from, int offset_px, const Conductances& flow, Image<glm::vec4>& to) {
  const int width = from.width(), height = from.height(), d = offset_px;
  for (int y = 0; y < height; ++y) {
    const glm::vec4 *here = from.row(y), *above = from.row(mirrored(y - d, height)),
                    *below = from.row(mirrored(y + d, height));
    const float *right = flow.right_.row(y), *left = flow.left_of_edge_.row(y), *down = flow.down_.row(y),
                *up = y < d ? flow.above_edge_.row(y) : flow.down_.row(y - d);
    glm::vec4* out = to.row(y);
    const auto put = [&](int x, float to_left, int before, int after) {
      const glm::vec4 own = here[x];
      out[x] = own + right[x] * (here[after] - own) + to_left * (here[before] - own) + down[x] * (below[x] - own) +
               up[x] * (above[x] - own);
    };
    const int first = std::min(d, width), last = std::max(first, width - d);
    for (int x = 0; x < first; ++x) put(x, left[x], mirrored(x - d, width), mirrored(x + d, width));
    for (int x = first; x < last; ++x) put(x, right[x - d], x - d, x + d);
    for (int x = last; x < width; ++x) put(x, right[x - d], x - d, mirrored(x + d, width));
  }
}

void invariant_pass(const Image<glm::vec4>& from, const Image<float>& rate, double inner_px, int k,
                    Image<glm::vec4>& to) {
  const int width = from.width(), height = from.height();
  // Between four pixels, as a GPU's filter reads them; its edge holds beyond.
  const auto between = [&](const auto& image, float x, float y) {
    x = std::clamp(x, 0.0F, static_cast<float>(width - 1));
    y = std::clamp(y, 0.0F, static_cast<float>(height - 1));
    const int left = static_cast<int>(x), top = static_cast<int>(y);
    const int right = std::min(left + 1, width - 1), bottom = std::min(top + 1, height - 1);
    const float u = x - static_cast<float>(left), v = y - static_cast<float>(top);
    return (image.at(left, top) * (1.0F - u) + image.at(right, top) * u) * (1.0F - v) +
           (image.at(left, bottom) * (1.0F - u) + image.at(right, bottom) * u) * v;
  };
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const float own_rate = rate.at(x, y);
      const float d = static_cast<float>(inner_px) * std::exp(static_cast<float>(k) * own_rate);
      const glm::vec4 own = from.at(x, y);
      glm::vec4 sum = own;
      const auto flow = [&](float ux, float uy) {
        const float nx = static_cast<float>(x) + ux, ny = static_cast<float>(y) + uy;
        sum += 0.5F * (own_rate + between(rate, nx, ny)) * (between(from, nx, ny) - own);
      };
      flow(d, 0.0F);
      flow(-d, 0.0F);
      flow(0.0F, d);
      flow(0.0F, -d);
      to.at(x, y) = sum;
    }
}

}  // namespace kasumi
