// A board's corners located again, once the lens is known well enough to undo its bending.
#pragma once

#include <functional>

#include "calib/board/board.hpp"

namespace kasumi {

// Where the picture shows a place on the board (metres, in its plane); empty: out of the lens's reach.
using BoardToPixel = std::function<std::optional<glm::dvec2>(const glm::dvec2&)>;

// In the picture a fisheye's rim bends the squares' sides and presses the squares together, so that a finder which
// expects straight sides misses the corner by up to a pixel and more. Here each corner is located in the board's own
// plane, as `shown` unbends it, and put back through `shown`; what is not yet known of the lens shifts both alike. A
// corner keeps its place where its surroundings are not in the picture, where no corner is, or where it is farther than
// half of view.clear_m from where `shown` expects it. Views without a picture stay as they are.
void refine_corners(BoardView& view, const BoardToPixel& shown);

}  // namespace kasumi
