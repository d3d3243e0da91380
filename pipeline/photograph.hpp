// A picture file as a photographer leaves it: 8 or 16 bits or floating point, any size.
#pragma once

#include <filesystem>

#include <glm/vec3.hpp>

#include "base/image.hpp"
#include "base/picture.hpp"
#include "base/result.hpp"

namespace kasumi {

struct Photograph {
  Image<glm::vec3> encoded;  // R G B, 0..1 for integer files; floating-point files are divided by their largest value
  Image<float> opacity;      // 0..1; empty: the file has no alpha
  double quantum = 0.0;      // 1/255, 1/65535, or 0 for floating point
};

// PNG, JPEG, TIFF, PNM, EXR (where OpenCV was built with it); grey becomes R = G = B; orientation
// tags are not followed, since calibration speaks of the stored pixels. Errors: bad_input.
Result<Photograph> read_photograph(const std::filesystem::path& path);

// For what wants 8 bits.
Image<Rgb8> to_rgb8(const Photograph& photograph);

// By the name's extension: PNG, TIFF (16 bits when the quantum is finer than 1/255, else 8), JPEG (8). Written beside
// and renamed. Errors: bad_input (another extension), io.
Result<> write_photograph(const std::filesystem::path& path, const Photograph& photograph);

}  // namespace kasumi
