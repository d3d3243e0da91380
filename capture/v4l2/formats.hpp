// V4L2's names for what we can read, and its words about colour.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/picture.hpp"
#include "capture/frame.hpp"

namespace kasumi {

struct V4l2PixelFormat {
  std::uint32_t code;    // V4L2_PIX_FMT_*
  FourCc format;         // what we call the same bytes
  std::uint32_t planes;  // in memory of their own; 1: one after the other
  int cost;              // of taking a picture, in an order: fewer bytes first, then copies, then decoding
  bool colour;           // a picture without is chosen only when it is asked for
};

// Empty: a format we do not read.
const V4l2PixelFormat* find_v4l2_format(std::uint32_t code);
// "NV12", "pBAA"; unprintable characters as '?'.
std::string v4l2_format_name(std::uint32_t code);

// What the driver says of the picture's colours, defaults resolved as V4L2 defines them. Empty: not YUV, JPEG (its own
// standard rules), or a matrix we do not have.
std::optional<YuvEncoding> v4l2_yuv_encoding(FourCc format, std::uint32_t colour_space, std::uint32_t ycbcr_encoding,
                                             std::uint32_t quantization);

}  // namespace kasumi
