// The camera's picture as pixels in memory, converted by the processor.
#pragma once

#include <cstddef>
#include <vector>

#include <glm/gtc/type_precision.hpp>

#include "base/image.hpp"
#include "base/picture.hpp"
#include "base/result.hpp"

namespace kasumi {

// A picture's planes, copied into memory that is used again.
class KeptPlanes {
 public:
  // Errors: bad_input (no pixels, missing planes, strides shorter than rows).
  Result<> take(const PictureView& picture);
  void clear() { view_ = {}; }
  bool empty() const { return view_.width == 0; }
  const PictureView& view() const { return view_; }

 private:
  std::vector<std::uint8_t> bytes_;
  PictureView view_;
};

// Whether planes and strides can hold the picture.
Result<> check_planes(const PictureView& picture);

// Of the layouts without chroma: bytes a pixel, and where red, green and blue lie.
struct RgbBytes {
  std::size_t step = 0, red = 0, green = 0, blue = 0;
};
inline RgbBytes rgb_bytes(PixelLayout layout) {
  switch (layout) {
    case PixelLayout::rgb8: return {3, 0, 1, 2};
    case PixelLayout::bgr8: return {3, 2, 1, 0};
    case PixelLayout::rgba8: return {4, 0, 1, 2};
    case PixelLayout::bgra8: return {4, 2, 1, 0};
    case PixelLayout::grey8: return {1, 0, 0, 0};
    default: return {};
  }
}

// Opaque; r, g, b as to_rgb() of base/picture.hpp. The image keeps its memory if it has the picture's size.
void to_rgba(const PictureView& picture, Image<glm::u8vec4>& pixels);

}  // namespace kasumi
