// The blocks of 16 x 16 pixels that hold what the object changes.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>

#include "base/image.hpp"
#include "gles/scene.hpp"

namespace kasumi {

constexpr int kBlock_px = 16;  // of a colour difference's 8 x 8 block, at most

// Whole blocks around all of them and their neighbours.
PixelBox blocks_around(const std::vector<PixelBox>& changed);
// By rows of blocks of `part`, 0 or 1 each: those that hold a changed pixel or its neighbour.
using BlockMap = Image<std::uint8_t>;
BlockMap blocks_of(const PixelBox& part, const std::vector<PixelBox>& changed);
// Those of them in which, and next to which, something else is to be seen than in `covered`.
BlockMap live_blocks_of(const PixelBox& part, const std::vector<PixelBox>& changed,
                        const std::vector<PixelBox>& covered);
// In rectangles of a row of blocks each, in pixels from the part's corner.
std::vector<PixelBox> rectangles_of(const BlockMap& blocks);
// A rectangle of the part's pixels with its neighbours, in the picture's.
PixelBox with_neighbours(const PixelBox& box, const PixelBox& part, glm::ivec2 picture);

}  // namespace kasumi
