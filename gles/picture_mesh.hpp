// The camera's picture as rectangles: where it passes unchanged, where the object covers it, and the edge between.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "base/image.hpp"
#include "gles/objects.hpp"
#include "gles/renderer.hpp"

namespace kasumi {

enum class PictureArea { plain = 0, covered = 1, edge = 2 };
constexpr std::size_t kPictureAreas = 3;

using PictureRectangles = std::array<std::vector<PixelBox>, kPictureAreas>;

// Cuts a picture so that no pixel is drawn twice. `coverage` is the box's, 0..1: rectangles are covered where it is 1
// throughout, plain where it is 0 throughout. Where the object is they are small, about half a cell of a grid of
// airlight that spans the box, so that airlight interpolated between their corners follows the grid.
PictureRectangles cut_picture(int width, int height, const PixelBox& box, const Image<float>& coverage);

// Those rectangles as triangles on the GPU.
class PictureMesh {
 public:
  static PictureMesh upload(const PictureRectangles& rectangles);
  bool empty(PictureArea area) const;
  void draw(PictureArea area) const;

 private:
  PictureMesh() = default;
  GlBuffer corners_;
  std::array<int, kPictureAreas + 1> first_{};
};

}  // namespace kasumi
