// Pictures of one camera that was moved a little between them, all brought onto one of them.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "base/image.hpp"
#include "calib/lens/lens.hpp"
#include "calib/pose/view_turn.hpp"

namespace kasumi {

// What a picture is recognised by (calib/pose/view_lines), at no more than some 1000 pixels across.
ViewLines lines_of_picture(const Lens& lens, const Image<glm::vec3>& encoded);

struct PlacedView {
  glm::dvec3 turn{0.0};  // ViewTurn's, from the reference
  bool seen = false;     // false: fog or night hides the lines; the turn is that of the picture nearest in order
  double agreement = 0.0;
};

struct SameViews {
  std::size_t reference = 0;
  std::vector<PlacedView> views;
};

// `views` in order of time. `reference`: the picture that all are brought onto; empty: of those with the clearest lines the
// one that stands most in the middle of them all. Nothing: no two pictures show the same view.
std::optional<SameViews> place_views(const Lens& lens, std::span<const ViewLines> views,
                                     std::optional<std::size_t> reference = {});

// The picture as the reference's camera would have taken it; pixels that it does not show are those of its edge. Turns of
// less than a third of a pixel are left alone: resampling would blur more than it mends.
Image<glm::vec3> turned_back(const Lens& lens, const Image<glm::vec3>& encoded, const glm::dvec3& turn);

}  // namespace kasumi
