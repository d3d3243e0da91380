// Completes a measured range map before haze is applied to it (H Sect 4.1; physics 9): holes are filled, the sky is put
// behind everything, with a margin between the two where it is uncertain which is which.
#pragma once

#include <cstdint>

#include <glm/vec3.hpp>

#include "base/image.hpp"
#include "base/result.hpp"

namespace kasumi {

struct RangeRules {
  // An undefined region with at least this share of the picture is sky (H: "the largest connected components"); smaller
  // ones are holes. 1: all are holes, as indoors.
  double smallest_sky_share = 0.02;
  double sky_range = 1.25;   // S_max, in farthest ranges; > 1
  int margin_px = 8;         // mu, on the sky's side
  int outline_reach_px = 0;  // how far outlines may lie from the picture's edges, to which they are moved; 0: they stay
};

struct HazeRange {
  Image<float> range;  // in units of the farthest measured: (0, 1], tapered to sky_range in the margin and the sky
  // Sums of the steps in ln(range) from surface to surface, along each row and down each column: two pixels lie on one
  // surface (or see the same surface through a gap) where the sums are equal. The surface's own slope is left out.
  // Modulo kRangeStepTurn.
  Image<float> steps_along_row, steps_down_column;
  double farthest_m = 0.0;
  Image<std::uint8_t> sky;  // 255 where sky, margin included; else 0
  int holes = 0;
  double hole_share = 0.0, sky_share = 0.0;  // of the picture
};

constexpr float kRangeStepTurn = 8.0F;  // e^8: a step from 1 m to 3 km is not mistaken for the same surface

// `range_m`: metres along the line of sight; 0 is undefined, infinity sky (indoors, smallest_sky_share 1: undefined). Deterministic. Errors: bad_input (nothing measured,
// options out of their ranges).
// `picture`: encoded, of the same size; not needed where outlines stay.
Result<HazeRange> prepare_range(const Image<float>& range_m, const RangeRules& options = {},
                                const Image<glm::vec3>& picture = {});

// The parts, for tests and for maps that need only some of them.
// Fills regions of zeros in `range`, each with the plane in space (linear in 1 / range) that most of its border agrees
// with, by RANSAC; the result stays within the nearest and farthest of the border. `labels`: 0 where nothing is to be
// done, else the number of the hole, 1..count.
void fill_holes(Image<float>& range, const Image<int>& labels, int count);
// Solves Laplace's equation in the sky's pixels less than margin_px from the scene. Boundary values: the scene's range
// on one side, sky_range on the other, no flow across the picture's edge.
void taper_into_sky(Image<float>& range, const Image<std::uint8_t>& sky, float sky_range, int margin_px);
// HazeRange::steps_* of a completed range map.
Image<float> range_steps_along_row(const Image<float>& range);
Image<float> range_steps_down_column(const Image<float>& range);

}  // namespace kasumi
