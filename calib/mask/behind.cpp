#include "calib/mask/behind.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <opencv2/imgproc.hpp>

#include "base/statistics.hpp"
#include "calib/mask/picture_series.hpp"

namespace kasumi {
namespace {

constexpr float kAlike = 0.3F;      // ln of light: two neighbours of what is behind
constexpr float kTwoKinds = 0.25F;  // ln of light: of what is behind and what sways

float unlikeness(const glm::vec3& a, const glm::vec3& b) {
  const glm::vec3 off = glm::abs(a - b);
  return std::max({off.r, off.g, off.b});
}

}  // namespace

glm::vec3 median_of(const std::vector<glm::vec3>& light) {
  glm::vec3 middle;
  for (int c = 0; c < 3; ++c) {
    std::vector<float> values;
    for (const auto& value : light) values.push_back(std::log(value[c]));
    middle[c] = median_in_place(values);
  }
  return middle;
}

PixelKinds kinds_of(const std::vector<glm::vec3>& light) {
  std::vector<float> seen;
  for (const auto& value : light) seen.push_back(std::log(glm::dot(kLumaWeights, value)));
  float low = quantile(seen, 0.02), high = quantile(seen, 0.98);
  for (int round = 0; round < 8; ++round) {
    float sums[2]{}, counts[2]{};
    for (const float value : seen) {
      const int kind = value > 0.5F * (low + high) ? 1 : 0;
      sums[kind] += value, counts[kind] += 1.0F;
    }
    if (counts[0] > 0.0F) low = sums[0] / counts[0];
    if (counts[1] > 0.0F) high = sums[1] / counts[1];
  }
  PixelKinds kinds;
  kinds.two = high - low > kTwoKinds;
  for (int c = 0; c < 3; ++c) {
    std::array<std::vector<float>, 2> values;
    for (std::size_t t = 0; t < light.size(); ++t)
      values[!kinds.two || seen[t] <= 0.5F * (low + high) ? 0 : 1].push_back(std::log(light[t][c]));
    kinds.dark[c] = median_in_place(values[0]);
    kinds.bright[c] = kinds.two ? median_in_place(values[1]) : kinds.dark[c];
  }
  return kinds;
}

Behind::Behind(const Image<PixelKinds>& kinds, const cv::Mat1b& swaying)
    : kinds_(kinds), light_(kinds.width(), kinds.height()) {
  known_ = swaying == 0;
  for (int y = 0; y < kinds.height(); ++y)
    for (int x = 0; x < kinds.width(); ++x) {
      if (known_(y, x) == 0) continue;
      light_.at(x, y) = kinds.at(x, y).dark;
      wake_neighbours(x, y);
    }
  follow();
  fill_gaps();
  follow();
}

// Gaps that no way through free pixels leads to: as what is behind the nearest pixel.
void Behind::fill_gaps() {
  cv::Mat1b unknown;
  cv::bitwise_not(known_, unknown);
  if (cv::countNonZero(known_) == 0) return;
  cv::Mat distances, labels;
  cv::distanceTransform(unknown, distances, labels, cv::DIST_L2, cv::DIST_MASK_5, cv::DIST_LABEL_PIXEL);
  std::vector<glm::ivec2> place(static_cast<std::size_t>(cv::countNonZero(known_)) + 1);
  for (int y = 0; y < kinds_.height(); ++y)
    for (int x = 0; x < kinds_.width(); ++x)
      if (known_(y, x) != 0) place[static_cast<std::size_t>(labels.at<int>(y, x))] = {x, y};
  std::vector<std::pair<glm::ivec2, glm::vec3>> gaps;
  for (int y = 0; y < kinds_.height(); ++y)
    for (int x = 0; x < kinds_.width(); ++x) {
      if (known_(y, x) != 0) continue;
      const auto& nearest = place[static_cast<std::size_t>(labels.at<int>(y, x))];
      if (const auto found = like(light_.at(nearest.x, nearest.y), x, y)) gaps.emplace_back(glm::ivec2{x, y}, *found);
    }
  for (const auto& [at, found] : gaps) set(at.x, at.y, found);
}

std::optional<glm::vec3> Behind::like(const glm::vec3& behind, int x, int y) const {
  const PixelKinds& kinds = kinds_.at(x, y);
  const float dark = unlikeness(kinds.dark, behind), bright = unlikeness(kinds.bright, behind);
  if (std::min(dark, bright) > kAlike) return std::nullopt;
  return dark < bright ? kinds.dark : kinds.bright;
}

void Behind::set(int x, int y, const glm::vec3& light) {
  if (known_(y, x) != 0) return;
  known_(y, x) = 255;
  light_.at(x, y) = light;
  wake_neighbours(x, y);
}

void Behind::wake_neighbours(int x, int y) {
  for (int v = y - 1; v <= y + 1; ++v)
    for (int u = x - 1; u <= x + 1; ++u)
      if (light_.contains(u, v) && known_(v, u) == 0) waiting_.push_back({u, v});
}

void Behind::follow() {
  for (; !waiting_.empty(); waiting_.pop_front()) {
    const auto [x, y] = std::pair{waiting_.front().x, waiting_.front().y};
    if (known_(y, x) != 0) continue;
    glm::vec3 sum(0.0F);
    float count = 0.0F;
    for (int v = y - 2; v <= y + 2; ++v)
      for (int u = x - 2; u <= x + 2; ++u)
        if (light_.contains(u, v) && known_(v, u) != 0) sum += light_.at(u, v), count += 1.0F;
    if (const auto found = like(sum / count, x, y)) set(x, y, *found);
  }
}

}  // namespace kasumi
