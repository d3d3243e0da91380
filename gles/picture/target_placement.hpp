// Where a target shows the picture.
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>

#include "gles/gl/target.hpp"
#include "gles/scene.hpp"

namespace kasumi {

// Where, and the transform to the target's pixels.
struct TargetPlacement {
  Letterbox box;
  glm::ivec2 picture{};  // its size
  bool same_size = true;
  bool top_row_first = true;
  glm::dmat3 pixel_to_clip{1.0};
  glm::dmat3 fragment_to_picture{1.0};

  TargetPlacement(const DrawTarget& target, int width, int height);
  // Of a part of the picture only, pixel by pixel, top row first.
  TargetPlacement(const PixelBox& part, int width, int height);
  // Binds the target and fills the area outside the picture with black.
  void begin(const DrawTarget& target, bool with_depth) const;
};

}  // namespace kasumi
