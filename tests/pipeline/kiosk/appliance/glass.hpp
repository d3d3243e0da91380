// Pictures of the glass, compared.
#pragma once

#include <algorithm>
#include <cstdlib>

#include "base/image.hpp"
#include "base/picture.hpp"

namespace kasumi {

// Of 255; 255 where they are not of one size.
inline double mean_difference(const Image<Rgb8>& one, const Image<Rgb8>& other) {
  if (one.width() != other.width() || one.height() != other.height()) return 255.0;
  double sum = 0.0;
  for (std::size_t i = 0; i < one.elements().size(); ++i)
    for (const int c : {0, 1, 2}) sum += std::abs(one.elements()[i][c] - other.elements()[i][c]);
  return sum / static_cast<double>(3 * one.elements().size());
}

// Where messages stand.
inline Image<Rgb8> upper_quarter(const Image<Rgb8>& picture) {
  Image<Rgb8> part(picture.width(), picture.height() / 4);
  std::copy_n(picture.elements().begin(), part.elements().size(), part.elements().begin());
  return part;
}

}  // namespace kasumi
