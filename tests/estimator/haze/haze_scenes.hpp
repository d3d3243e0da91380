// Pictures to blur, for tests of haze.
#pragma once

#include <cmath>

#include <glm/vec4.hpp>

#include "base/image.hpp"
#include "estimator/haze/diffusion.hpp"
#include "estimator/haze/range.hpp"

namespace kasumi {

// Fine and coarse, dark and bright, and the same on every machine: bars that get finer to the right, rotated with
// height.
inline Image<glm::vec4> bars(int width, int height) {
  Image<glm::vec4> picture(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double phase = 0.02 * x + 0.0009 * x * x * (1.0 + 0.4 * y / height);
      const double value = std::sin(phase) > 0.0 ? 0.9 : 0.1;
      picture.at(x, y) = glm::vec4(glm::dvec4(value, 1.0 - value, 0.5 + 0.3 * std::sin(0.3 * y), 0.2 + 0.6 * value));
    }
  return picture;
}

inline BlurMap everywhere(int width, int height, double sigma_px) {
  BlurMap map;
  map.sigma_px = Image<float>(width, height, static_cast<float>(sigma_px));
  return map;
}

// A square object in front of a distant wall: ranges (of the farthest), and light of the two.
struct ObjectBeforeWall {
  Image<float> range;
  Image<glm::vec4> light;
  Image<std::uint8_t> on_object;
};
inline ObjectBeforeWall object_before_wall(int size, float object_range, float object_light, float wall_light) {
  ObjectBeforeWall scene{Image<float>(size, size, 1.0F), Image<glm::vec4>(size, size, glm::vec4(wall_light)),
                         Image<std::uint8_t>(size, size)};
  for (int y = size / 3; y < 2 * size / 3; ++y)
    for (int x = size / 3; x < 2 * size / 3; ++x) {
      scene.range.at(x, y) = object_range;
      scene.light.at(x, y) = glm::vec4(object_light);
      scene.on_object.at(x, y) = 255;
    }
  return scene;
}

inline glm::dvec4 sum_of(const Image<glm::vec4>& picture) {
  glm::dvec4 sum{0.0};
  for (const auto& pixel : picture.elements()) sum += glm::dvec4(pixel);
  return sum;
}

}  // namespace kasumi
