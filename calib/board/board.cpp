#include "calib/board/board.hpp"

#include <algorithm>
#include <cmath>

#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace kasumi {
namespace {

// A window that sees one corner only, however small a fisheye's rim draws the squares.
int refinement_window(const std::vector<cv::Point2f>& corners, const Board& board) {
  double nearest = 1e9;
  for (int row = 0; row < board.rows; ++row)
    for (int column = 0; column + 1 < board.columns; ++column) {
      const auto at = static_cast<std::size_t>(row * board.columns + column);
      nearest = std::min(nearest, cv::norm(corners[at + 1] - corners[at]));
    }
  return std::clamp(static_cast<int>(0.4 * nearest), 2, 11);
}

bool find_corners(const cv::Mat& picture, const Board& board, bool fast, std::vector<cv::Point2f>& corners) {
  const cv::Size size(board.columns, board.rows);
  // The older finder follows lines that a fisheye bends, and is quick to see that there is no board.
  const int how = cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE;
  if (!cv::findChessboardCorners(picture, size, corners, fast ? how | cv::CALIB_CB_FAST_CHECK : how))
    return !fast &&
           cv::findChessboardCornersSB(picture, size, corners, cv::CALIB_CB_ACCURACY | cv::CALIB_CB_NORMALIZE_IMAGE);
  const int window = refinement_window(corners, board);
  cv::cornerSubPix(picture, corners, {window, window}, {-1, -1},
                   {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 50, 1e-3});
  return true;
}

}  // namespace

std::optional<BoardView> find_board(const Image<std::uint8_t>& grey, const Board& board, std::string name,
                                    bool fast) try {
  cv::Mat picture(grey.height(), grey.width(), CV_8UC1);
  for (int y = 0; y < grey.height(); ++y) std::copy_n(grey.row(y), grey.width(), picture.ptr<std::uint8_t>(y));
  std::vector<cv::Point2f> corners;
  if (!find_corners(picture, board, fast, corners)) return std::nullopt;
  BoardView view{std::move(name), {}, {}};
  view.clear_m = 0.8 * board.square_m;
  for (int row = 0; row < board.rows; ++row)
    for (int column = 0; column < board.columns; ++column) {
      const auto& corner = corners[static_cast<std::size_t>(row * board.columns + column)];
      view.pixels.emplace_back(corner.x, corner.y);
      view.on_board.emplace_back(board.square_m * column, board.square_m * row);
    }
  return view;
} catch (const cv::Exception&) {
  return std::nullopt;
}

}  // namespace kasumi
