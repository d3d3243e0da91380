// Lens calibration from pictures of a board: compares models by cross-validation, drops bad views, and reports what
// the pictures leave undetermined.
#pragma once

#include "base/result.hpp"
#include "calib/lens/lens_fit.hpp"

namespace kasumi {

struct LensCandidate {
  LensFamily family{};
  std::optional<double> held_out_rms_px;  // of views left out in turn, only their pose fitted; empty: it did not fit
};

struct DroppedView {
  std::string name;
  std::string reason;  // for a person
};

// Where the corners were, of all views used.
struct BoardCoverage {
  static constexpr int kCells = kCoverageCells;
  std::array<int, kCells * kCells> corners{};  // row by row, from the top left of the picture
  double covered = 0.0;                        // part of the cells that can see anything which saw a corner
  Radians farthest;                            // off the axis
  Radians largest_tilt;             // between the boards of two views; boards all alike leave the focal length open
  std::vector<std::string> advice;  // for a person; empty when all is well
};

struct LensCalibration {
  LensFit fit;                   // of the chosen family to the views used; lens.largest_angle as the request has it
  std::vector<BoardView> views;  // used, in the order of fit.views
  std::vector<DroppedView> dropped;
  std::vector<LensCandidate> candidates;
  BoardCoverage coverage;
};

struct LensCalibrationRequest {
  std::optional<LensFamily> family{};      // empty: chosen by cross-validation
  std::optional<Radians> largest_angle{};  // empty: the farthest corner's and 5 deg more
  int folds = 5;
};

constexpr std::size_t kFewestViews = 4;

// Corners are located again with the lens as it is known by then, where views have their picture, and only then a view
// is dropped when its rms is more than 3 x the others' median and more than 0.3 px above it, at most a third of
// them. Of models within 2 % of the best held-out error, the first in kLensFamilies is chosen. Errors (bad_input): too
// few views; no model fits.
Result<LensCalibration> calibrate_lens(std::vector<BoardView> views, int width, int height,
                                       const LensCalibrationRequest& options = {});

}  // namespace kasumi
