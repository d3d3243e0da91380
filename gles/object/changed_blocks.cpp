#include "gles/object/changed_blocks.hpp"

#include <algorithm>

#include "gles/gpu_model/projection.hpp"

namespace kasumi {
namespace {

PixelBox around(const std::vector<PixelBox>& boxes) {
  PixelBox whole;
  for (const PixelBox& box : boxes) whole = united(whole, box);
  return whole;
}

// Whole blocks around the changed pixels and their neighbours.
PixelBox blocks_around_box(const PixelBox& changed) {
  const auto down = [](int pixel) { return std::max(pixel - 1, 0) / kBlock_px * kBlock_px; };
  const auto up = [](int pixel) { return (pixel + kBlock_px) / kBlock_px * kBlock_px; };
  return {down(changed.left), down(changed.top), up(changed.right), up(changed.bottom)};
}

}  // namespace

PixelBox blocks_around(const std::vector<PixelBox>& changed) {
  return blocks_around_box(around(changed));
}

BlockMap blocks_of(const PixelBox& part, const std::vector<PixelBox>& changed) {
  const int columns = (part.right - part.left) / kBlock_px, rows = (part.bottom - part.top) / kBlock_px;
  BlockMap taken(columns, rows, 0);
  for (const PixelBox& box : changed) {
    const PixelBox blocks = blocks_around_box(box);
    for (int y = (blocks.top - part.top) / kBlock_px; y < std::min((blocks.bottom - part.top) / kBlock_px, rows); ++y)
      for (int x = (blocks.left - part.left) / kBlock_px; x < std::min((blocks.right - part.left) / kBlock_px, columns);
           ++x)
        taken.at(x, y) = 1;
  }
  return taken;
}

std::vector<PixelBox> rectangles_of(const BlockMap& blocks) {
  std::vector<PixelBox> found;
  for (int y = 0; y < blocks.height(); ++y)
    for (int x = 0; x < blocks.width();) {
      const int first = x;
      while (x < blocks.width() && blocks.at(x, y) == blocks.at(first, y)) ++x;
      if (blocks.at(first, y)) found.push_back({first * kBlock_px, y * kBlock_px, x * kBlock_px, (y + 1) * kBlock_px});
    }
  return found;
}

}  // namespace kasumi
