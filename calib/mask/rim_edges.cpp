#include "calib/mask/rim_edges.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>

#include <opencv2/imgproc.hpp>

#include "base/statistics.hpp"

namespace kasumi {
namespace {

constexpr double kBlur_px = 1.2;
constexpr float kWeakest = 0.9f;    // tones a pixel: a step of one grey level in the dark, blurred
constexpr float kDarkShare = 0.1f;  // of the light parts' value, below which steps count less and less
constexpr std::array kChannelWeights{1.0f, 1.0f, 0.8f};  // fringes and flare are violet, blue or red
constexpr std::size_t kMostEdges = 6500;

// Of each pixel the slope of the channel that changes most: a rim may show in one colour only.
cv::Mat2f steepest_slopes(const cv::Mat3f& tones) {
  cv::Mat3f across, down;
  cv::Sobel(tones, across, CV_32F, 1, 0, 3, 0.125);
  cv::Sobel(tones, down, CV_32F, 0, 1, 3, 0.125);
  cv::Mat2f slopes(tones.size());
  for (int y = 0; y < tones.rows; ++y)
    for (int x = 0; x < tones.cols; ++x) {
      float best = -1.0f;
      for (int c = 0; c < 3; ++c) {
        const float u = across(y, x)[c], v = down(y, x)[c], size = u * u + v * v;
        if (size <= best) continue;
        best = size;
        slopes(y, x) = {u, v};
      }
    }
  return slopes;
}

}  // namespace

EqualNoiseTones tones_of(const Image<Rgb8>& picture, int longer_side_px) {
  const cv::Mat3b whole(picture.height(), picture.width(),
                        reinterpret_cast<cv::Vec3b*>(const_cast<Rgb8*>(picture.elements().data())));
  EqualNoiseTones small;
  small.shrink = std::max(1.0, static_cast<double>(std::max(whole.cols, whole.rows)) / longer_side_px);
  cv::Mat3b shrunk = whole;
  if (small.shrink > 1.0) cv::resize(whole, shrunk, {}, 1.0 / small.shrink, 1.0 / small.shrink, cv::INTER_AREA);
  cv::Mat3b clean;  // of hot pixels, stars and thin lines
  cv::medianBlur(shrunk, clean, 3);
  std::vector<std::uint8_t> values;
  for (int y = 0; y < clean.rows; y += 4)
    for (int x = 0; x < clean.cols; x += 4)
      values.push_back(std::max({clean(y, x)[0], clean(y, x)[1], clean(y, x)[2]}));
  const float dark = std::clamp(kDarkShare * static_cast<float>(quantile_in_place(values, 0.95)), 2.0f, 8.0f);
  cv::Mat3f tone(1, 256);
  for (int i = 0; i < 256; ++i)
    for (int c = 0; c < 3; ++c)
      tone(0, i)[c] = kChannelWeights[static_cast<std::size_t>(c)] * 16.0f * std::sqrt(static_cast<float>(i) + dark);
  cv::LUT(clean, tone, small.tones);
  cv::GaussianBlur(small.tones, small.tones, {}, kBlur_px);
  return small;
}

std::vector<RimEdge> find_edges(const cv::Mat3f& tones) {
  const cv::Mat2f slopes = steepest_slopes(tones);
  cv::Mat1f size(slopes.size());
  std::vector<float> sizes;
  for (int y = 0; y < size.rows; ++y)
    for (int x = 0; x < size.cols; ++x) {
      const auto& slope = slopes(y, x);
      size(y, x) = std::sqrt(slope[0] * slope[0] + slope[1] * slope[1]);
      if (x % 3 == 0 && y % 3 == 0) sizes.push_back(size(y, x));
    }
  // A quarter of nearly every picture is even: sky, surround.
  const float weakest = std::max(kWeakest, 3.0f * quantile_in_place(sizes, 0.25));
  std::vector<RimEdge> edges;
  for (int y = 1; y + 1 < size.rows; ++y)
    for (int x = 1; x + 1 < size.cols; ++x) {
      const float here = size(y, x);
      if (here < weakest) continue;
      const auto& slope = slopes(y, x);
      const glm::vec2 normal{slope[0] / here, slope[1] / here};
      const bool flat = std::abs(normal.x) > std::abs(normal.y);
      // One pixel along the normal's larger part.
      const float t = flat ? normal.y / normal.x : normal.x / normal.y;
      const auto beside = [&](int side) {
        const int away = std::abs(t) < 0.414f ? 0 : (t > 0.0f ? side : -side);
        return flat ? size(y + away, x + side) : size(y + side, x + away);
      };
      const float before = beside(-1), after = beside(1);
      if (here < before || here <= after) continue;
      const float bend = before - 2.0f * here + after;
      const float shift = bend < 0.0f ? std::clamp(0.5f * (before - after) / bend, -0.5f, 0.5f) : 0.0f;
      const glm::vec2 step = flat ? glm::vec2{1.0f, std::abs(t) < 0.414f ? 0.0f : std::copysign(1.0f, t)}
                                  : glm::vec2{std::abs(t) < 0.414f ? 0.0f : std::copysign(1.0f, t), 1.0f};
      edges.push_back({glm::vec2{x, y} + shift * step, normal, here / (here + 3.0f * weakest)});
    }
  if (edges.size() > kMostEdges) {
    std::ranges::nth_element(edges, edges.begin() + kMostEdges, std::ranges::greater{}, &RimEdge::strength);
    edges.resize(kMostEdges);
  }
  return edges;
}

}  // namespace kasumi
