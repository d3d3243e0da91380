// How far two pictures are apart: as far as can be where their sizes differ.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "base/image.hpp"
#include "base/picture.hpp"

namespace kasumi {

struct PictureDifference {
  int largest = 255, changed = std::numeric_limits<int>::max();  // of any channel, of 255; pixels that are not the same
  double mean = 255.0;                                           // of all channels, of 255
  double psnr_db = 0.0;
};

inline PictureDifference difference(const Image<Rgb8>& one, const Image<Rgb8>& other) {
  PictureDifference found;
  if (one.width() != other.width() || one.height() != other.height()) return found;
  found.largest = found.changed = 0;
  double sum = 0.0, squares = 0.0;
  const double values = 3.0 * static_cast<double>(one.elements().size());
  for (std::size_t i = 0; i < one.elements().size(); ++i) {
    found.changed += one.elements()[i] != other.elements()[i] ? 1 : 0;
    for (int c = 0; c < 3; ++c) {
      const int off = std::abs(int{one.elements()[i][c]} - int{other.elements()[i][c]});
      found.largest = std::max(found.largest, off);
      sum += off;
      squares += off * off;
    }
  }
  found.mean = sum / values;
  found.psnr_db = 10.0 * std::log10(255.0 * 255.0 * values / std::max(squares, 1e-9));
  return found;
}

}  // namespace kasumi
