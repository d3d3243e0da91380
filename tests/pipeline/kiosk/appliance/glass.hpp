// Pictures of the glass, compared.
#pragma once

#include <algorithm>
#include <cstdlib>

#include "base/image.hpp"
#include "base/picture.hpp"

namespace kasumi {

// Where messages stand.
inline Image<Rgb8> upper_quarter(const Image<Rgb8>& picture) {
  Image<Rgb8> part(picture.width(), picture.height() / 4);
  std::copy_n(picture.elements().begin(), part.elements().size(), part.elements().begin());
  return part;
}

}  // namespace kasumi
