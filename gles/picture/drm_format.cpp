#include "gles/picture/drm_format.hpp"

namespace kasumi {

std::string drm_format_text(std::uint32_t format) {
  std::string text;
  for (unsigned shift = 0; shift < 32; shift += 8) text += static_cast<char>((format >> shift) & 0xFFu);
  return text;
}

std::uint32_t drm_format_of(PixelLayout layout) {
  switch (layout) {
    case PixelLayout::rgb8: return drm_format("BG24");
    case PixelLayout::bgr8: return drm_format("RG24");
    case PixelLayout::rgba8: return drm_format("XB24");
    case PixelLayout::bgra8: return drm_format("XR24");
    case PixelLayout::grey8: return drm_format("R8  ");
    case PixelLayout::yuyv: return drm_format("YUYV");
    case PixelLayout::uyvy: return drm_format("UYVY");
    case PixelLayout::nv12: return drm_format("NV12");
    case PixelLayout::i420: return drm_format("YU12");
    case PixelLayout::i422: return drm_format("YU16");
    case PixelLayout::i444: return drm_format("YU24");
  }
  return 0;
}

bool is_yuv(PixelLayout layout) {
  switch (layout) {
    case PixelLayout::yuyv:
    case PixelLayout::uyvy:
    case PixelLayout::nv12:
    case PixelLayout::i420:
    case PixelLayout::i422:
    case PixelLayout::i444: return true;
    default: return false;
  }
}

}  // namespace kasumi
