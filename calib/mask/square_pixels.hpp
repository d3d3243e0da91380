// Pictures whose pixels are not square, made square, and back.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/image.hpp"

namespace kasumi {

// Columns repeated or left out until there are `width`.
template <class Pixel>
Image<Pixel> with_columns(Image<Pixel> picture, int width) {
  if (picture.width() == width) return picture;
  Image<Pixel> made(width, picture.height());
  const double step = static_cast<double>(picture.width()) / width;
  for (int y = 0; y < made.height(); ++y)
    for (int x = 0; x < made.width(); ++x)
      made.at(x, y) = picture.at(std::clamp(static_cast<int>(std::lround(x * step)), 0, picture.width() - 1), y);
  return made;
}

// `pixel_aspect`: a pixel's width over its height.
template <class Pixel>
Image<Pixel> with_square_pixels(Image<Pixel> picture, double pixel_aspect) {
  const int width = std::max(1, static_cast<int>(std::lround(picture.width() * pixel_aspect)));
  return with_columns(std::move(picture), width);
}

}  // namespace kasumi
