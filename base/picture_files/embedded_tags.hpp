// What a picture's file says beside its samples: how it is to be turned, what its colours mean, when and where it was
// taken. JPEG, PNG, TIFF, WebP, HEIF.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/picture_header.hpp"

namespace kasumi {

struct EmbeddedTags {
  int orientation = 1;                // EXIF's, 1 to 8
  std::vector<std::uint8_t> profile;  // ICC; empty: none
  std::vector<std::uint8_t> exif;     // a TIFF of tags, from its "II" or "MM" on; empty: none
};

constexpr std::uint16_t kTiffProfile = 34675;  // the tag of an ICC profile

// Damaged tags are left out; a profile of more than 4 MB is refused (bad_input). Errors also: unsupported (HEIF, and the
// module is not there).
Result<EmbeddedTags> embedded_tags(const PictureHeader& header, std::span<const std::uint8_t> file);

}  // namespace kasumi
