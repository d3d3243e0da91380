// When and where a picture was taken, as EXIF that may be written into what is made of it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace kasumi {

// `exif`: a TIFF of tags. Kept are the times, their offsets and the place, by libexif; nothing of the camera, no
// orientation (it has been applied) and no thumbnail (it shows the other picture). With ColorSpace sRGB, little-endian. Empty:
// nothing of that is there and `always` is false.
std::vector<std::uint8_t> time_and_place(std::span<const std::uint8_t> exif, bool always = false);

}  // namespace kasumi
