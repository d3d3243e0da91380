// The kernel's names of pixel formats: four characters, from the highest bits down ("AB24" lies in memory as R G B A).
#pragma once

#include <cstdint>
#include <string>

#include "base/picture.hpp"

namespace kasumi {

constexpr std::uint32_t drm_format(const char (&code)[5]) {
  std::uint32_t format = 0;
  for (unsigned i = 0; i < 4; ++i) format |= static_cast<std::uint32_t>(static_cast<unsigned char>(code[i])) << (8 * i);
  return format;
}
std::string drm_format_text(std::uint32_t format);

// A whole picture of that layout in one buffer. Grey has only R8, which shows as red.
std::uint32_t drm_format_of(PixelLayout layout);
bool is_yuv(PixelLayout layout);

}  // namespace kasumi
