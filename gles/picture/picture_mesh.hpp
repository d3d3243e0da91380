// The rectangles of a cut picture as triangles on the GPU.
#pragma once

#include <array>

#include "gles/gl/objects.hpp"
#include "gles/picture/picture_cutting.hpp"

namespace kasumi {

class PictureMesh {
 public:
  static PictureMesh upload(const CutRectangles& rectangles);
  bool empty(CutArea area) const;
  void draw(CutArea area) const;

 private:
  PictureMesh() = default;
  GlBuffer corners_;
  std::array<int, kCutAreas + 1> first_{};
};

}  // namespace kasumi
