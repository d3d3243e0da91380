// Every pixel layout, for tests that try all of them.
#pragma once

#include <array>

#include "base/picture.hpp"

namespace kasumi {

inline constexpr std::array kLayouts{PixelLayout::rgb8,  PixelLayout::bgr8, PixelLayout::rgba8, PixelLayout::bgra8,
                                     PixelLayout::grey8, PixelLayout::yuyv, PixelLayout::uyvy,  PixelLayout::nv12,
                                     PixelLayout::i420,  PixelLayout::i422, PixelLayout::i444};

}  // namespace kasumi
