// Luminance and colour that a smooth sky has at every element, asked at few of them.
#pragma once

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "estimator/turbidity/sky_samples.hpp"

namespace kasumi {

// On a lattice and between its nodes; near the sun, where it is curved, as it is. Row by row.
template <class Sky>  // glm::vec2 of a direction
class ExpectedElements {
 public:
  ExpectedElements(const ElementGeometry& geometry, const SunDirection& sun, Sky sky)
      : geometry_(geometry), sky_(std::move(sky)), sun_(sun) {
    const Image<glm::vec3>& direction = geometry.direction;
    nodes_ = Image<glm::vec2>((direction.width() + kStep - 1) / kStep + 1, (direction.height() + kStep - 1) / kStep + 1,
                              glm::vec2{std::numeric_limits<float>::quiet_NaN()});
    for (int j = 0; j < nodes_.height(); ++j)
      for (int i = 0; i < nodes_.width(); ++i) {
        const int x = i * kStep, y = j * kStep;
        if (direction.contains(x, y) && direction.at(x, y).z > kLowest) nodes_.at(i, j) = sky_(direction.at(x, y));
      }
    across_.resize(static_cast<std::size_t>(nodes_.width()));
  }
  void begin_row(int y) {
    directions_ = geometry_.direction.row(y);
    const float v = static_cast<float>(y % kStep) / kStep;
    const glm::vec2 *above = nodes_.row(y / kStep), *below = nodes_.row(y / kStep + 1);
    for (std::size_t i = 0; i < across_.size(); ++i) across_[i] = (1.0f - v) * above[i] + v * below[i];
  }
  glm::vec2 at(int x) const {
    const glm::vec3& direction = directions_[x];
    if (glm::dot(direction, sun_) > kCurved) return sky_(direction);
    const glm::vec2* node = across_.data() + x / kStep;
    const float u = static_cast<float>(x % kStep) / kStep;
    const glm::vec2 between = (1.0f - u) * node[0] + u * node[1];
    return std::isfinite(between.x) ? between : sky_(direction);
  }

 private:
  static constexpr int kStep = 4;          // elements between nodes: clear sky is smooth over a degree
  static constexpr float kLowest = 0.1f;   // sine of the elevation
  static constexpr float kCurved = 0.97f;  // cosine of 14 deg
  const ElementGeometry& geometry_;
  Sky sky_;
  glm::vec3 sun_;
  Image<glm::vec2> nodes_;
  std::vector<glm::vec2> across_;  // the nodes of two rows, blended for the row between them
  const glm::vec3* directions_ = nullptr;
};

}  // namespace kasumi
