// The steps to which a JPEG rounds the coefficients of its blocks of 8 x 8 samples.
#pragma once

#include <array>
#include <cstdint>

namespace kasumi {

// In levels of 255; row by row, the slowest in both directions first.
struct JpegSteps {
  std::array<std::uint16_t, 64> luma{};
  std::array<std::uint16_t, 64> chroma{};
  friend bool operator==(const JpegSteps&, const JpegSteps&) = default;
};

}  // namespace kasumi
