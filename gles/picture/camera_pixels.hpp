// The camera's picture as pixels in memory, converted by the processor.
#pragma once

#include <vector>

#include <glm/gtc/type_precision.hpp>
#include <glm/vec3.hpp>

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

// Opaque; r, g, b as to_rgb() of base/picture.hpp. The image keeps its memory if it has the picture's size.
void to_rgba(const PictureView& picture, Image<glm::u8vec4>& pixels);

// A pixel's encoded values as a shader computes them (camera_picture.glsl): not rounded, perhaps beyond 0..1.
glm::vec3 encoded_at(const PictureView& picture, const YuvToRgb& matrix, int x, int y);

}  // namespace kasumi
