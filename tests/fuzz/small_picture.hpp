// Decoding a large picture is slow and shows nothing that a small one does not: fuzzers leave out those that readers would accept.
#pragma once

#include "base/picture_header.hpp"

namespace kasumi {

inline bool is_large(const std::optional<PictureHeader>& header) {
  constexpr PictureLimits kMegapixel{1 << 14, 1 << 20};
  return header && check_size(*header, kPhotographLimits) && !check_size(*header, kMegapixel);
}

inline bool is_large_picture(std::span<const std::uint8_t> file) {
  return is_large(picture_header(file));
}

// Anywhere in the file, as in a model with its pictures.
inline bool holds_large_picture(std::span<const std::uint8_t> file) {
  for (std::size_t at = 0; at < file.size(); ++at) {
    if (file[at] != 0x89 && file[at] != 0xff) continue;  // PNG and JPEG begin so
    if (is_large_picture(file.subspan(at))) return true;
  }
  return is_large_picture(file);
}

}  // namespace kasumi
