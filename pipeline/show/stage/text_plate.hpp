// Light text on a dark, translucent, rounded background.
#pragma once

#include <cstdint>

#include "base/image.hpp"
#include "gles/picture/flat_picture.hpp"

namespace kasumi {

// `coverage`: of each pixel by the text, 0..255; the background fills that picture.
Image<Rgba8> text_plate(const Image<std::uint8_t>& coverage, double background_opacity, double radius_px);

}  // namespace kasumi
