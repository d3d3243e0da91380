// A camera's picture with less light, for what a visitor is not to look at.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "base/picture.hpp"

namespace kasumi {

class DimmedPicture {
 public:
  // kDimmed of the encoded values, in the picture's own layout and range. The result is valid until the next call.
  const PictureView& dim(const PictureView& picture);

 private:
  std::array<std::vector<std::uint8_t>, 3> bytes_;
  PictureView view_;
};

constexpr double kDimmed = 0.4;  // of encoded values; about an eighth of the light

}  // namespace kasumi
