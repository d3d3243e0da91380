// Sharpness of static edges and stray light over dark areas, which reveal lost focus and a fogged lens.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <glm/vec2.hpp>

#include "base/image.hpp"
#include "calib/lens/lens.hpp"
#include "calib/pose/view_turn.hpp"

namespace kasumi {

// A step from dark to bright in a picture, as wide as the lens makes it.
struct ViewEdge {
  glm::dvec2 pixel{};
  glm::dvec2 normal{};     // unit, towards the bright side
  double spread_px = 0.0;  // standard deviation of the Gaussian with as steep a step, the pixel's own square included
  double contrast = 0.0;   // (bright - dark) / (bright + dark), in light
  double step = 0.0;       // (bright - dark) / the picture's mean light
};

// The clearest ones, at most two in each of 24 x 14 fields. `light` is linear, of the camera's own size; usable 0: not
// there (empty: anywhere).
std::vector<ViewEdge> find_edges(const Image<float>& light, const Image<std::uint8_t>& usable);

struct EdgeChange {
  int edges = 0;                           // found again
  int sought = 0;                          // that are still in the picture
  double spread_ratio = 1.0;               // median of spread now over then
  double spread_sigma = 0.0;               // one standard deviation of that median
  double before_px = 0.0, now_px = 0.0;    // median spreads of those found again
  double contrast_ratio = 1.0;             // median of contrast now over then, those that are gone counted as 0
  double step_low = 1.0, step_high = 1.0;  // first and last fifth of steps now over then
};
// The same edges, looked for where the turned camera sees them. Haze takes their contrast and leaves their width; a
// lens out of focus takes both. Empty: fewer than 12 are to be seen in the picture.
std::optional<EdgeChange> compare_edges(const Lens& lens, std::span<const ViewEdge> reference, const ViewTurn& turn,
                                        const Image<float>& light);

// The darkest hundredths of a view (3 %, at most 500 of their elements).
struct DarkPlaces {
  std::vector<glm::ivec2> places;
  double light = 0.0;  // theirs, over the view's mean light
};
// Empty: the view is too small.
std::optional<DarkPlaces> darkest_places(const Lens& lens, const ShrunkView& view);

struct Veil {
  double before = 0.0, now = 0.0;  // light of the places that were darkest in the reference, over the mean light
};
// Of those places, wherever they are seen now. Air puts no light before what is near; a lens that is fogged puts a share
// of all light everywhere. Empty: too few of them are to be seen.
std::optional<Veil> compare_veil(const Lens& lens, const DarkPlaces& reference, const ShrunkView& now,
                                 const ViewTurn& turn);

}  // namespace kasumi
