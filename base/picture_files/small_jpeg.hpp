// A JPEG at an eighth of its size, which takes less than half the time: most of its code is read and little made of it.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "base/picture_files/picture_file.hpp"

namespace kasumi {

constexpr int kSmallJpegShrink = 8;
// R G B, each the mean of 8 x 8 pixels, or of what is left of them at the right and lower edge. Empty: damaged, or of
// another kind than cameras write (grey, four colours, several scans).
std::optional<DecodedFile> decode_small_jpeg(std::span<const std::uint8_t> file);

}  // namespace kasumi
