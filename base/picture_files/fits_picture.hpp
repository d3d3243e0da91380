// FITS pictures of all-sky cameras, as programs for astronomical cameras write them.
#pragma once

#include <cstdint>
#include <span>

#include <opencv2/core.hpp>

namespace kasumi {

// The first image of the file: grey, Bayer's pattern (BAYERPAT) or three planes, of any type. Its samples are light;
// given back are 16 bits of sRGB, B G R or grey, of the brightest value that can be (DATAMAX, SATURATE, else what the
// type of integer holds, else the largest there is). FITS counts rows from below unless ROWORDER says TOP-DOWN. Throws
// cv::Exception with what is wrong.
cv::Mat read_fits(std::span<const std::uint8_t> file);

}  // namespace kasumi
