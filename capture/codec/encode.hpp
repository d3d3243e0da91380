// Encodes RGB pictures as a camera would deliver them. For generated and assembled fixtures.
#pragma once

#include <cstdint>
#include <vector>

#include "base/image.hpp"
#include "base/picture.hpp"
#include "base/result.hpp"
#include "capture/frame.hpp"

namespace kasumi {

enum class ChromaSubsampling { s420, s422, s444, grey };

// Quality 1..100 as in libjpeg. Errors (bad_input): empty or oversized picture, quality out of range.
Result<std::vector<std::uint8_t>> encode_jpeg(const Image<Rgb8>& image, int quality, ChromaSubsampling subsampling);

struct EncodingFormat {
  YuvEncoding yuv_encoding = YuvEncoding::bt601_full;  // for YUYV, UYVY, NV12, YU12, and the Y of GREY
  std::uint32_t stride = 0;                            // bytes per row of the first plane; 0: packed
  int jpeg_quality = 90;
  ChromaSubsampling jpeg_subsampling = ChromaSubsampling::s420;
};

// A good frame in this format: payload, size, stride and bytes_used are filled in; timestamps, sequence, exposure and
// gain are left to the caller. Chroma is the mean of the pixels that share it; nothing is dithered. Padding bytes are
// 0. Errors (bad_input): empty or oversized picture, unknown format, stride smaller than a row.
Result<Frame> encode_frame(const Image<Rgb8>& image, FourCc format, const EncodingFormat& options = {});

}  // namespace kasumi
