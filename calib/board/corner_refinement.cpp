#include "calib/board/corner_refinement.hpp"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace kasumi {
namespace {

constexpr int kFewestSteps = 3, kMostSteps = 10;  // of the window, each way from the corner
constexpr double kLeastContrast = 10.0;           // of 255
constexpr int kAround = 2;                        // more, which cv::cornerSubPix asks for

// The board around one corner, seen from straight above.
struct UnbentPatch {
  cv::Mat picture;
  double step_m = 0.0;
  int steps = 0;  // of the window
};

std::optional<UnbentPatch> unbend(const cv::Mat& picture, const glm::dvec2& corner, double clear_m,
                                  const BoardToPixel& shown) {
  const auto middle = shown(corner), across = shown(corner + glm::dvec2{0.3 * clear_m, 0.0}),
             down = shown(corner + glm::dvec2{0.0, 0.3 * clear_m});
  if (!middle || !across || !down) return std::nullopt;
  // About as fine as the picture where the board is largest in it.
  const double px_per_m = std::max(glm::distance(*middle, *across), glm::distance(*middle, *down)) / (0.3 * clear_m);
  UnbentPatch patch;
  patch.steps = std::clamp(static_cast<int>(clear_m * px_per_m) - 1, kFewestSteps, kMostSteps);
  patch.step_m = std::min(clear_m / (patch.steps + 1), 1.0 / px_per_m);
  const int half = patch.steps + kAround;
  cv::Mat columns(2 * half + 1, 2 * half + 1, CV_32F), rows(columns.size(), CV_32F);
  for (int y = -half; y <= half; ++y)
    for (int x = -half; x <= half; ++x) {
      const auto at = shown(corner + patch.step_m * glm::dvec2{x, y});
      if (!at || at->x < 0.0 || at->y < 0.0 || at->x > picture.cols - 1 || at->y > picture.rows - 1)
        return std::nullopt;
      columns.at<float>(y + half, x + half) = static_cast<float>(at->x);
      rows.at<float>(y + half, x + half) = static_cast<float>(at->y);
    }
  cv::remap(picture, patch.picture, columns, rows, cv::INTER_CUBIC, cv::BORDER_REPLICATE);
  return patch;
}

// How much brighter one pair of opposite quarters is than the other: 0 where there is no corner.
double contrast_of(const UnbentPatch& patch) {
  const int middle = patch.picture.cols / 2, side = patch.steps;
  const auto mean = [&](int x, int y) { return cv::mean(patch.picture(cv::Rect(x, y, side, side)))[0]; };
  const int before = middle - side, after = middle + 1;
  return 0.5 * std::abs(mean(before, before) + mean(after, after) - mean(before, after) - mean(after, before));
}

}  // namespace

void refine_corners(BoardView& view, const BoardToPixel& shown) {
  if (!view.picture || view.picture->empty() || !(view.clear_m > 0.0)) return;
  const auto& grey = *view.picture;
  // OpenCV only reads from it.
  const cv::Mat picture(grey.height(), grey.width(), CV_8UC1, const_cast<std::uint8_t*>(grey.elements().data()));
  for (std::size_t i = 0; i < view.pixels.size(); ++i) {
    const auto patch = unbend(picture, view.on_board[i], view.clear_m, shown);
    if (!patch || contrast_of(*patch) < kLeastContrast) continue;
    const float middle = 0.5F * static_cast<float>(patch->picture.cols - 1);
    std::vector<cv::Point2f> found{{middle, middle}};
    cv::cornerSubPix(patch->picture, found, {patch->steps, patch->steps}, {-1, -1},
                     {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 50, 1e-3});
    const glm::dvec2 moved_m = patch->step_m * glm::dvec2{found[0].x - middle, found[0].y - middle};
    if (glm::length(moved_m) > 0.5 * view.clear_m) continue;
    if (const auto pixel = shown(view.on_board[i] + moved_m)) view.pixels[i] = *pixel;
  }
}

}  // namespace kasumi
