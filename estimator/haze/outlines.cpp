#include "estimator/haze/outlines.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <glm/geometric.hpp>
#include <opencv2/imgproc.hpp>

namespace kasumi {
namespace {

constexpr float kStep = 0.05F;        // in ln(range) between neighbours: one surface ends, another begins
constexpr float kSameColour = 0.04F;  // standard deviation of a surface's encoded colours
constexpr int kRounds = 2;            // a thin thing's map is right only where its neighbours' already is

// 255 where a step is within reach.
Image<std::uint8_t> near_steps(const Image<float>& range, int reach_px) {
  Image<std::uint8_t> at(range.width(), range.height());
  const auto differs = [&](int x, int y, int ox, int oy) {
    if (!range.contains(ox, oy)) return false;
    const float one = range.at(x, y), other = range.at(ox, oy);
    return one > 0.0F && other > 0.0F && std::abs(std::log(one / other)) > kStep;
  };
  for (int y = 0; y < range.height(); ++y)
    for (int x = 0; x < range.width(); ++x)
      if (differs(x, y, x + 1, y) || differs(x, y, x, y + 1)) at.at(x, y) = 255;
  cv::Mat map(range.height(), range.width(), CV_8U, at.elements().data());
  cv::dilate(map, map, cv::getStructuringElement(cv::MORPH_RECT, {2 * reach_px + 1, 2 * reach_px + 1}));
  return at;
}

struct Weighted {
  float range, weight;
};

float weighted_median(std::vector<Weighted>& values) {
  std::ranges::sort(values, {}, &Weighted::range);
  float all = 0.0F, sum = 0.0F;
  for (const auto& value : values) all += value.weight;
  for (const auto& value : values)
    if ((sum += value.weight) >= 0.5F * all) return value.range;
  return values.back().range;
}

}  // namespace

void move_outlines_to_edges(const Image<glm::vec3>& picture, Image<float>& range, int reach_px) {
  if (reach_px < 1 || range.empty()) return;
  const int stride = std::max(1, reach_px / 4);  // some ten samples across suffice
  const float near = 2.0F / static_cast<float>(reach_px * reach_px);
  std::vector<Weighted> values;
  for (int round = 0; round < kRounds; ++round) {
    const Image<float> before = range;
    const auto concerned = near_steps(before, reach_px);
    for (int y = 0; y < range.height(); ++y)
      for (int x = 0; x < range.width(); ++x) {
        if (concerned.at(x, y) == 0) continue;
        values.clear();
        const glm::vec3 colour = picture.at(x, y);
        for (int v = -reach_px; v <= reach_px; v += stride)
          for (int u = -reach_px; u <= reach_px; u += stride) {
            if (!before.contains(x + u, y + v) || before.at(x + u, y + v) <= 0.0F) continue;
            const glm::vec3 off = picture.at(x + u, y + v) - colour;
            const float unlike =
                glm::dot(off, off) / (2.0F * kSameColour * kSameColour) + near * static_cast<float>(u * u + v * v);
            values.push_back({before.at(x + u, y + v), std::exp(-unlike)});
          }
        if (!values.empty()) range.at(x, y) = weighted_median(values);
      }
  }
}

}  // namespace kasumi
