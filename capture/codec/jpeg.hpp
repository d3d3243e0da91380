// Decodes JPEG to its YUV planes, and says whether one is whole.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/jpeg_steps.hpp"
#include "base/picture.hpp"
#include "base/result.hpp"

namespace kasumi {

struct JpegPlanes {
  PictureView view;  // i420, i422, i444 or grey8; bt601_full
  std::shared_ptr<const std::vector<std::uint8_t>> samples;
  JpegSteps steps;
};

// Accepts what cameras send: missing Huffman tables, bytes between segments, no end marker. Errors (bad_input): not a
// JPEG, not the expected size, damaged or truncated pixels, progressive, arithmetic, CMYK or RGB, subsampling other
// than 4:2:0, 4:2:2, 4:4:4 and grey.
Result<JpegPlanes> decode_jpeg(std::span<const std::uint8_t> bytes, int width, int height);

// Whether all pixels of a JPEG of any kind are there, which other decoders fill with grey in silence. A missing end
// marker and bytes between segments are no damage, as above. Errors (bad_input): what is missing.
Result<> check_jpeg(std::span<const std::uint8_t> bytes);

}  // namespace kasumi
