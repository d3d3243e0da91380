#include "gles/composite/changed_blocks.hpp"

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

BlockMap live_blocks_of(const PixelBox& part, const std::vector<PixelBox>& changed,
                        const std::vector<PixelBox>& covered) {
  BlockMap live = blocks_of(part, changed);
  const int width = part.right - part.left, height = part.bottom - part.top;
  Image<std::uint8_t> mask(width, height, 0);
  for (const PixelBox& box : covered)
    for (int y = box.top; y < box.bottom; ++y)
      std::fill_n(&mask.at(box.left - part.left, y - part.top), box.right - box.left, std::uint8_t{1});
  const auto is_covered = [&](int left, int top) {
    for (int y = top - 1; y <= top + kBlock_px; ++y)
      for (int x = left - 1; x <= left + kBlock_px; ++x)
        if (!mask.contains(x, y) || mask.at(x, y) == 0) return false;
    return true;
  };
  for (int y = 0; y < live.height(); ++y)
    for (int x = 0; x < live.width(); ++x)
      if (live.at(x, y) && is_covered(x * kBlock_px, y * kBlock_px)) live.at(x, y) = 0;
  return live;
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

PixelBox with_neighbours(const PixelBox& box, const PixelBox& part, glm::ivec2 picture) {
  return {std::max(part.left + box.left - 1, 0), std::max(part.top + box.top - 1, 0),
          std::min(part.left + box.right + 1, picture.x), std::min(part.top + box.bottom + 1, picture.y)};
}

}  // namespace kasumi
