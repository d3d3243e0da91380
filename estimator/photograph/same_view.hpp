// Pictures of one camera that was moved a little between them, all brought onto one of them.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "base/image.hpp"
#include "calib/lens/lens.hpp"
#include "calib/pose/view_lines.hpp"

namespace kasumi {

// What a picture is recognised by (calib/pose/view_lines), at no more than some 1000 pixels across.
ViewLines lines_of_picture(const Lens& lens, const Image<glm::vec3>& encoded);

// Where a pixel of one picture is in another: moved, turned about the axis, zoomed a little.
struct ViewMove {
  glm::dvec2 along{1.0, 0.0};  // of a pixel to the right; one downwards is (-along.y, along.x)
  glm::dvec2 shift{0.0};       // of pixel (0, 0)
  glm::dvec2 at(const glm::dvec2& pixel) const {
    return {along.x * pixel.x - along.y * pixel.y + shift.x, along.y * pixel.x + along.x * pixel.y + shift.y};
  }
};
// The way back; and first `inner`, then `outer`.
ViewMove inverse_of(const ViewMove& move);
ViewMove joined(const ViewMove& outer, const ViewMove& inner);

// From `reference` to `now`: the whole picture's shift by correlation, then that of its parts, and the move on which most
// of these agree. Nothing: fog or night hides the lines, or it is another view.
std::optional<ViewMove> find_move(const ViewLines& reference, const ViewLines& now);

struct PlacedView {
  ViewMove move;      // from the reference
  bool seen = false;  // false: its lines are hidden; the move is that of the picture nearest in order
};

struct SameViews {
  std::size_t reference = 0;
  std::vector<PlacedView> views;
};

// `views` in order of time. `reference`: the picture that all are brought onto; empty: of those with the clearest lines the
// one that stands most in the middle of them all. Nothing: no two pictures show the same view.
std::optional<SameViews> place_views(std::span<const ViewLines> views, std::optional<std::size_t> reference = {});

// The picture as it would have been from the reference's place; pixels that it does not show are those of its edge. Moves
// of less than a third of a pixel are left alone: resampling would blur more than it mends.
Image<glm::vec3> moved_back(const Image<glm::vec3>& encoded, const ViewMove& move);

}  // namespace kasumi
