// HEIF: HEIC, a phone's photographs, and AVIF, by libheif. Part of the module.
#pragma once

#include <cstdint>
#include <span>

#include <opencv2/core.hpp>

#include "base/picture_files/embedded_tags.hpp"

namespace kasumi {

// The picture that the file names as its first, cut and turned as it says: B G R (A), of 8 bits, or of 16 where it has
// more. Throws cv::Exception with what is wrong; of more light than a display's white (PQ, HLG) is none that is read.
cv::Mat read_heif(std::span<const std::uint8_t> file);
// Its profile, or one made of the primaries that it names; nothing where the file is damaged. It is turned already.
EmbeddedTags read_heif_tags(std::span<const std::uint8_t> file);

}  // namespace kasumi
