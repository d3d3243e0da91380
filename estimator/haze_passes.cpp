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

// Two rows of pixels, or one with itself.
struct Row {
  const float* rate;
  const float* steps;  // null: one surface
};
float matched_between(const Row& row, int x, const Row& other, int ox) {
  const float rate = std::min(row.rate[x], other.rate[ox]);
  return row.steps == nullptr ? rate : rate * joined(row.steps[x], other.steps[ox]);
}

Row row_of(const Image<float>& rate, const Image<float>& steps, int y) {
  return {rate.row(y), steps.empty() ? nullptr : steps.row(y)};
}

}  // namespace

void Conductances::set_means(const Image<float>& rate) {
  const int width = rate.width(), height = rate.height();
  for (int y = 0; y < height; ++y) {
    const float *here = rate.row(y), *above = rate.row(mirrored(y - 1, height)),
                *below = rate.row(mirrored(y + 1, height));
    for (int x = 0; x < width; ++x) {
      right_.at(x, y) = 0.5F * (here[x] + here[mirrored(x + 1, width)]);
      left_.at(x, y) = 0.5F * (here[x] + here[mirrored(x - 1, width)]);
      down_.at(x, y) = 0.5F * (here[x] + below[x]);
      up_.at(x, y) = 0.5F * (here[x] + above[x]);
    }
  }
}

void Conductances::set_matched(const MatchedPass& pass, const Image<float>& wanted_px2,
                               const Image<float>& steps_along_row, const Image<float>& steps_down_column) {
  const int width = wanted_px2.width(), height = wanted_px2.height(), d = pass.offset_px;
  const auto from = static_cast<float>(pass.from_px2), most = static_cast<float>(pass.variance_px2);
  const auto per_variance = static_cast<float>(0.5 / (static_cast<double>(d) * d));
  std::ranges::transform(wanted_px2.elements(), rate_.elements().begin(),
                         [&](float wanted) { return per_variance * std::min(std::max(wanted - from, 0.0F), most); });
  for (int y = 0; y < height; ++y) {
    const Row here = row_of(rate_, steps_along_row, y);
    float *right = right_.row(y), *left = left_.row(y);
    for (int x = 0; x < width - d; ++x) right[x] = matched_between(here, x, here, x + d);
    for (int x = std::max(width - d, 0); x < width; ++x)
      right[x] = matched_between(here, x, here, mirrored(x + d, width));
    for (int x = 0; x < std::min(d, width); ++x) left[x] = matched_between(here, x, here, mirrored(x - d, width));
    for (int x = d; x < width; ++x) left[x] = right[x - d];
  }
  for (int y = 0; y < height; ++y) {
    const Row here = row_of(rate_, steps_down_column, y);
    const Row below = row_of(rate_, steps_down_column, mirrored(y + d, height));
    float* down = down_.row(y);
    for (int x = 0; x < width; ++x) down[x] = matched_between(here, x, below, x);
    float* up = up_.row(y);
    if (y >= d) {
      std::copy_n(down_.row(y - d), width, up);
      continue;
    }
    const Row above = row_of(rate_, steps_down_column, mirrored(y - d, height));
    for (int x = 0; x < width; ++x) up[x] = matched_between(here, x, above, x);
  }
}

void symmetric_pass(const Image<glm::vec4>& from, int offset_px, const Conductances& flow, Image<glm::vec4>& to) {
  const int width = from.width(), height = from.height(), d = offset_px;
  for (int y = 0; y < height; ++y) {
    const glm::vec4 *here = from.row(y), *above = from.row(mirrored(y - d, height)),
                    *below = from.row(mirrored(y + d, height));
    const float *right = flow.right_.row(y), *left = flow.left_.row(y), *down = flow.down_.row(y),
                *up = flow.up_.row(y);
    glm::vec4* out = to.row(y);
    const auto put = [&](int x, int before, int after) {
      const glm::vec4 own = here[x];
      out[x] = own + right[x] * (here[after] - own) + left[x] * (here[before] - own) + down[x] * (below[x] - own) +
               up[x] * (above[x] - own);
    };
    const int first = std::min(d, width), last = std::max(first, width - d);
    for (int x = 0; x < first; ++x) put(x, mirrored(x - d, width), mirrored(x + d, width));
    for (int x = first; x < last; ++x) put(x, x - d, x + d);
    for (int x = last; x < width; ++x) put(x, mirrored(x - d, width), mirrored(x + d, width));
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
