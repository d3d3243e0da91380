// V4L2's codes for the formats Kasumi reads, and its colour metadata.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/picture.hpp"
#include "capture/frame.hpp"

namespace kasumi {

struct V4l2PixelFormat {
  std::uint32_t code;    // V4L2_PIX_FMT_*
  FourCc format;         // Kasumi's name for the same bytes
  std::uint32_t planes;  // in separate memory; 1: contiguous
  int cost;              // rank by processing cost: first bytes, then copies, then decoding
  bool colour;           // formats without colour are chosen only on request
};

// Null: not a supported format.
const V4l2PixelFormat* find_v4l2_format(std::uint32_t code);
// "NV12", "pBAA"; unprintable characters as '?'.
std::string v4l2_format_name(std::uint32_t code);

// The driver's colour metadata, with defaults resolved as V4L2 defines them. Empty: not YUV, JPEG (defined by its own
// standard), or an unsupported matrix.
std::optional<YuvEncoding> v4l2_yuv_encoding(FourCc format, std::uint32_t colour_space, std::uint32_t ycbcr_encoding,
                                             std::uint32_t quantization);

}  // namespace kasumi
