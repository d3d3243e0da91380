// How far two pictures of one size are apart, pixel by pixel.
#pragma once

#include <cstddef>
#include <optional>

#include "pipeline/lab/comparison/similarity.hpp"

namespace kasumi {

struct PixelErrors {
  std::size_t pixels = 0;         // that count
  double mean_absolute = 0.0;     // of all channels, in steps of 1 / 255
  double largest = 0.0;           // of any channel, in steps of 1 / 255
  std::optional<double> psnr_db;  // of the mean square of all channels, against the white of the file; nothing: equal
  struct {
    double mean = 0.0, at_95_percent = 0.0, largest = 0.0;
  } ciede2000;  // of sRGB under D65
};

// Encoded values 0..1. At least one pixel counts.
PixelErrors pixel_errors(const Image<glm::vec3>& one, const Image<glm::vec3>& other, const CountedPixels& counted);

}  // namespace kasumi
