// JPEG to the YUV planes it is made of.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/picture.hpp"
#include "base/result.hpp"

namespace kasumi {

struct JpegPlanes {
  PictureView view;  // i420, i422, i444 or grey8; bt601_full
  std::shared_ptr<const std::vector<std::uint8_t>> samples;
};

// Huffman tables may be missing, as webcams leave them out. What a camera may do is forgiven: bytes beside the
// segments, no end marker. Errors (bad_input): not a JPEG, another size than the one expected, damaged or cut pixels,
// progressive, arithmetic, CMYK or RGB, subsampling other than 4:2:0, 4:2:2, 4:4:4 and grey.
Result<JpegPlanes> decode_jpeg(std::span<const std::uint8_t> bytes, int width, int height);

}  // namespace kasumi
