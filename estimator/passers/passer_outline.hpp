// From covered cells to a passer's outline: the covered share of each pixel, and the light behind.
#pragma once

#include <cstdint>

#include <glm/gtc/type_precision.hpp>

#include "base/image.hpp"
#include "estimator/passers/expected_scene.hpp"
#include "estimator/passers/picture_part.hpp"

namespace kasumi {

// Pixels of the camera's picture from `left`, `top` on. Around it, nothing is in front.
struct PassersInFront {
  int left = 0, top = 0;
  // r, g, b: what is behind, as the camera would encode it; a: the share of the pixel that is free, 255: all. The
  // outermost pixels are free. Empty: no passers.
  Image<glm::u8vec4> pixels;
  bool empty() const { return pixels.empty(); }
};

// `covered`: 1 for cells in which a passer was found.
PassersInFront outline_of(const PicturePart& picture, const ExpectedScene& expected,
                          const Image<std::uint8_t>& covered);

}  // namespace kasumi
