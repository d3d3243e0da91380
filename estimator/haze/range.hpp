// A measured range map made whole before haze is laid over it (H Sect 4.1; physics 9): holes filled, the sky put behind
// everything, and a margin between the two where nobody knows which is which.
#pragma once

#include <cstdint>

#include "base/image.hpp"
#include "base/result.hpp"

namespace kasumi {

struct HazeRangeOptions {
  // An undefined region that takes at least this share of the picture is sky (H: "the largest connected components"),
  // smaller ones are holes. 1: all are holes, as indoors.
  double smallest_sky_share = 0.02;
  double sky_range = 1.25;  // S_max, in farthest ranges; > 1
  int margin_px = 8;        // mu, on the sky's side
};

struct HazeRange {
  Image<float> range;  // of the farthest that was measured: (0, 1], tapered to sky_range in the margin and the sky
  // Sums of the steps in ln(range) from surface to surface, along each row and down each column: two pixels lie on one
  // surface, or on one behind the other's gap, where they are alike. What a surface's own slope adds is left out.
  // Modulo kRangeStepTurn.
  Image<float> steps_along_row, steps_down_column;
  double farthest_m = 0.0;
  Image<std::uint8_t> sky;  // 255; 0 elsewhere, margin included: it is sky
  int holes = 0;
  double hole_share = 0.0, sky_share = 0.0;  // of the picture
};

constexpr float kRangeStepTurn = 8.0F;  // e^8: nothing steps from 1 m to 3 km and means the same surface

// `range_m`: metres along the line of sight; 0 is undefined. Deterministic. Errors: bad_input (nothing measured,
// options out of their ranges).
Result<HazeRange> prepare_range(const Image<float>& range_m, const HazeRangeOptions& options = {});

// The parts, for tests and for maps that need only some of them.
// Regions of zeros in `range`, each filled by the plane of space (linear in 1 / range) that most of what borders on it
// agrees with, by RANSAC; never beyond the nearest and farthest of its border. `labels`: 0 where nothing is to be done,
// else the number of the hole, 1..count.
void fill_holes(Image<float>& range, const Image<int>& labels, int count);
// Laplace's equation in the sky's pixels that lie less than margin_px from the scene: the scene's range on one side,
// sky_range on the other, nothing flows over the picture's edge.
void taper_into_sky(Image<float>& range, const Image<std::uint8_t>& sky, float sky_range, int margin_px);
// HazeRange::steps_* of a whole range map.
Image<float> range_steps_along_row(const Image<float>& range);
Image<float> range_steps_down_column(const Image<float>& range);

}  // namespace kasumi
