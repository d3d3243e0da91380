// A lens model fitted to views of a board: bundle adjustment of the model and every view's pose (Ceres).
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <glm/mat3x3.hpp>

#include "calib/board/board.hpp"
#include "calib/lens/lens_description.hpp"

namespace kasumi {

enum class LensFamily { pinhole, opencv_fisheye, scaramuzza };
// In order of preference: the renderer needs a pinhole, and many programs read OpenCV's parameters.
inline constexpr std::array kLensFamilies{LensFamily::pinhole, LensFamily::opencv_fisheye, LensFamily::scaramuzza};
std::string_view name_of(LensFamily family);  // as the key `model` has it

struct BoardPose {
  glm::dmat3 rotation{1.0};  // board to camera frame; the board's plane is its x, y
  glm::dvec3 translation_m{0.0};
};

// From rays alone, without a lens: linear, and right for rays far off the axis as well. Empty when the corners do not
// determine it (fewer than four, or all on a line).
std::optional<BoardPose> board_pose(std::span<const glm::dvec3> rays, std::span<const glm::dvec2> on_board);

struct ViewResiduals {
  BoardPose pose;
  std::vector<glm::dvec2> residuals_px;  // seen minus modelled, one for each corner
  double rms_px = 0.0;                   // root of the mean squared distance
};

struct LensFit {
  LensFamily family = LensFamily::opencv_fisheye;
  LensDescription lens;  // largest_angle: the farthest corner's
  double rms_px = 0.0;   // over all corners of all views, OpenCV's way
  std::vector<ViewResiduals> views;
  // One standard deviation, from the fit's curvature and its own residuals; empty when the views leave it undetermined.
  struct Sigma {
    double focal_px = 0.0;
    glm::dvec2 centre_px{};
  };
  std::optional<Sigma> sigma;
};

// Scaramuzza: a1 = 0 and e = 0, for a turn of the picture plane is a turn of the camera. Corners far off weigh less
// (Huber, 1 px), so that one bad view shows itself rather than bending the others. Deterministic. Empty: no start was
// found from which it converges.
std::optional<LensFit> fit_lens(LensFamily family, std::span<const BoardView> views, int width, int height);

// How well a lens explains a view that it was not fitted to: only the pose is free.
std::optional<ViewResiduals> residuals_of(const LensDescription& lens, const BoardView& view);

}  // namespace kasumi
