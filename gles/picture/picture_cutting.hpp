// Divides the camera's picture into rectangles: unchanged, covered by the object, and the edge between.
#pragma once

#include <array>
#include <vector>

#include "base/image.hpp"
#include "gles/scene.hpp"

namespace kasumi {

enum class CutArea { plain = 0, covered = 1, edge = 2 };
constexpr std::size_t kCutAreas = 3;

using CutRectangles = std::array<std::vector<PixelBox>, kCutAreas>;

// Cuts a picture so that no pixel is drawn twice and drawing is cheap. `coverage`, 0..1, is the box's: a rectangle is
// covered if it is 1 throughout, plain if it is 0 throughout.
CutRectangles cut_picture(int width, int height, const PixelBox& box, const Image<float>& coverage);

// Cuts covered and edge rectangles at the grid's lines, so that interpolating between their corners reproduces the
// grid.
CutRectangles cut_at_lines(const CutRectangles& rectangles, const AirlightGrid& grid);

}  // namespace kasumi
