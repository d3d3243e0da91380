#include "capture/v4l2/formats.hpp"

#include <linux/videodev2.h>

#include <algorithm>
#include <array>

namespace kasumi {

namespace {

// Formats with X or A first in memory (BX24, BA24, RX24, RA24, RGB4) are not supported.
constexpr std::array<V4l2PixelFormat, 16> kFormats{{
    {V4L2_PIX_FMT_NV12, four_cc("NV12"), 1, 0, true},
    {V4L2_PIX_FMT_YUV420, four_cc("YU12"), 1, 1, true},
    {V4L2_PIX_FMT_YUYV, four_cc("YUYV"), 1, 2, true},
    {V4L2_PIX_FMT_UYVY, four_cc("UYVY"), 1, 3, true},
    {V4L2_PIX_FMT_XBGR32, four_cc("XR24"), 1, 4, true},  // B G R x
    {V4L2_PIX_FMT_ABGR32, four_cc("XR24"), 1, 5, true},  // B G R A
    {V4L2_PIX_FMT_BGR32, four_cc("XR24"), 1, 6, true},   // B G R and X or A, the legacy name
    {V4L2_PIX_FMT_RGBX32, four_cc("AB24"), 1, 7, true},  // R G B x
    {V4L2_PIX_FMT_RGBA32, four_cc("AB24"), 1, 8, true},  // R G B A
    {V4L2_PIX_FMT_BGR24, four_cc("BGR3"), 1, 9, true},
    {V4L2_PIX_FMT_RGB24, four_cc("RGB3"), 1, 10, true},
    {V4L2_PIX_FMT_NV12M, four_cc("NV12"), 2, 11, true},
    {V4L2_PIX_FMT_YUV420M, four_cc("YU12"), 3, 12, true},
    {V4L2_PIX_FMT_MJPEG, kMjpg, 1, 13, true},
    {V4L2_PIX_FMT_JPEG, kMjpg, 1, 14, true},
    {V4L2_PIX_FMT_GREY, four_cc("GREY"), 1, 15, false},
}};

bool is_yuv(FourCc format) {
  const auto layout = layout_of(format);
  return layout && (*layout == PixelLayout::yuyv || *layout == PixelLayout::uyvy || *layout == PixelLayout::nv12 ||
                    *layout == PixelLayout::i420);
}

}  // namespace

const V4l2PixelFormat* find_v4l2_format(std::uint32_t code) {
  const auto found = std::find_if(kFormats.begin(), kFormats.end(), [&](const auto& f) { return f.code == code; });
  return found == kFormats.end() ? nullptr : &*found;
}

std::string v4l2_format_name(std::uint32_t code) {
  std::string name;
  for (int shift = 0; shift < 32; shift += 8) {
    const auto c = static_cast<char>(code >> shift & 0x7f);
    name += c < ' ' || c > '~' ? '?' : c;
  }
  return name;
}

std::optional<YuvEncoding> v4l2_yuv_encoding(FourCc format, std::uint32_t colour_space, std::uint32_t ycbcr_encoding,
                                             std::uint32_t quantization) {
  if (!is_yuv(format) || colour_space == V4L2_COLORSPACE_DEFAULT) return std::nullopt;
  if (ycbcr_encoding == V4L2_YCBCR_ENC_DEFAULT)
    ycbcr_encoding = V4L2_MAP_YCBCR_ENC_DEFAULT(static_cast<v4l2_colorspace>(colour_space));
  const bool by_709 = ycbcr_encoding == V4L2_YCBCR_ENC_709 || ycbcr_encoding == V4L2_YCBCR_ENC_XV709;
  const bool by_601 = ycbcr_encoding == V4L2_YCBCR_ENC_601 || ycbcr_encoding == V4L2_YCBCR_ENC_XV601 ||
                      ycbcr_encoding == V4L2_YCBCR_ENC_SYCC;
  if (!by_709 && !by_601) return std::nullopt;
  if (quantization == V4L2_QUANTIZATION_DEFAULT)
    quantization = colour_space == V4L2_COLORSPACE_JPEG ? V4L2_QUANTIZATION_FULL_RANGE : V4L2_QUANTIZATION_LIM_RANGE;
  const bool full = quantization == V4L2_QUANTIZATION_FULL_RANGE;
  if (by_709) return full ? YuvEncoding::bt709_full : YuvEncoding::bt709_limited;
  return full ? YuvEncoding::bt601_full : YuvEncoding::bt601_limited;
}

}  // namespace kasumi
