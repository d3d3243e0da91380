// A small picture within a page, so that nobody fetches or keeps it.
#pragma once

#include <string>

#include "base/image.hpp"
#include "base/picture.hpp"

namespace kasumi::report {

// "data:image/bmp;base64,...": a Windows bitmap of 24 bits a pixel, which every browser shows and which needs no library.
std::string bitmap_address(const Image<Rgb8>& picture);

}  // namespace kasumi::report
