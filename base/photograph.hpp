// A photograph in memory, from a file of any size with 8 or 16 bits per channel or floating point.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "base/image.hpp"
#include "base/picture.hpp"

namespace kasumi {

struct Photograph {
  Image<glm::vec3> encoded;  // R G B, 0..1 for integer files; floating-point files are divided by their largest value
  Image<float> opacity;      // 0..1; empty: the file has no alpha
  double quantum = 0.0;      // 1/255, 1/65535, or 0 for floating point
  std::vector<std::uint8_t> origin = {};  // EXIF of when and where it was taken; empty: not known
};

// Rounded to 8 bits per channel.
Image<Rgb8> to_rgb8(const Photograph& photograph);

}  // namespace kasumi
