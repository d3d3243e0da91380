// The edges of a picture that was made small, as a search for its image circle reads them.
#pragma once

#include <vector>

#include <glm/vec2.hpp>
#include <opencv2/core.hpp>

#include "base/image.hpp"
#include "base/picture.hpp"

namespace kasumi {

// 16 sqrt(value + a share of the picture's brightness), by channel: noise counts about the same in light and dark, and
// faint flare less than a rim.
struct EqualNoiseTones {
  cv::Mat3f tones;
  double shrink = 1.0;  // pixels of the picture across one of these
};
EqualNoiseTones tones_of(const Image<Rgb8>& picture, int longer_side_px);

struct RimEdge {
  glm::vec2 point{};
  glm::vec2 normal{};     // of unit length, towards the lighter side
  float strength = 0.0f;  // 0..1: half at several times the noise
};
// Thin edges of any channel, to a fraction of a pixel; the strongest where there are very many.
std::vector<RimEdge> find_edges(const cv::Mat3f& tones);

}  // namespace kasumi
