// Text without any font file, for when nothing of the disk can be relied on: coarse capitals that are part of the program.
#pragma once

#include <string_view>

#include "gles/picture/flat_picture.hpp"

namespace kasumi {

// Light capitals on a dark background, `height_px` a line, broken at spaces before they are wider than
// `largest_width_px`. Characters other than a-z, A-Z, 0-9 and . , : - ' / ( ) become a question mark.
Image<Rgba8> draw_plain_letters(std::string_view text, double height_px, int largest_width_px);

}  // namespace kasumi
