// The camera's picture as rectangles: where it passes unchanged, where the object covers it, and the edge between.
#pragma once

#include <array>
#include <vector>

#include "base/image.hpp"
#include "gles/scene.hpp"

namespace kasumi {

enum class PictureArea { plain = 0, covered = 1, edge = 2 };
constexpr std::size_t kPictureAreas = 3;

using PictureRectangles = std::array<std::vector<PixelBox>, kPictureAreas>;

// Cuts a picture so that no pixel is drawn twice and drawing is cheap. `coverage` is the box's, 0..1: rectangles are
// covered where it is 1 throughout, plain where it is 0 throughout.
PictureRectangles cut_picture(int width, int height, const PixelBox& box, const Image<float>& coverage);

// Cuts covered and edge rectangles where the grid has its lines, so that light interpolated between their corners
// follows the grid.
PictureRectangles cut_at_lines(const PictureRectangles& rectangles, const AirlightGrid& grid);

}  // namespace kasumi
