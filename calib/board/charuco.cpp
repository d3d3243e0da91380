#include "calib/board/charuco.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/ranges.h>
#include <glm/geometric.hpp>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace kasumi {
namespace {

namespace aruco = cv::aruco;

struct NamedDictionary {
  std::string_view name;
  aruco::PREDEFINED_DICTIONARY_NAME number;
  int markers, bits;
};
constexpr std::array kDictionaries{
    NamedDictionary{"DICT_4X4_50", aruco::DICT_4X4_50, 50, 4},
    NamedDictionary{"DICT_4X4_100", aruco::DICT_4X4_100, 100, 4},
    NamedDictionary{"DICT_4X4_250", aruco::DICT_4X4_250, 250, 4},
    NamedDictionary{"DICT_4X4_1000", aruco::DICT_4X4_1000, 1000, 4},
    NamedDictionary{"DICT_5X5_50", aruco::DICT_5X5_50, 50, 5},
    NamedDictionary{"DICT_5X5_100", aruco::DICT_5X5_100, 100, 5},
    NamedDictionary{"DICT_5X5_250", aruco::DICT_5X5_250, 250, 5},
    NamedDictionary{"DICT_5X5_1000", aruco::DICT_5X5_1000, 1000, 5},
    NamedDictionary{"DICT_6X6_50", aruco::DICT_6X6_50, 50, 6},
    NamedDictionary{"DICT_6X6_100", aruco::DICT_6X6_100, 100, 6},
    NamedDictionary{"DICT_6X6_250", aruco::DICT_6X6_250, 250, 6},
    NamedDictionary{"DICT_6X6_1000", aruco::DICT_6X6_1000, 1000, 6},
};

const NamedDictionary* dictionary_of(const CharucoBoard& board) {
  const auto* const found = std::ranges::find(kDictionaries, board.dictionary, &NamedDictionary::name);
  return found == kDictionaries.end() ? nullptr : found;
}

cv::Ptr<aruco::CharucoBoard> opencv_board(const CharucoBoard& board, const NamedDictionary& dictionary) {
  return aruco::CharucoBoard::create(board.columns, board.rows, static_cast<float>(board.square_m),
                                     static_cast<float>(board.marker_m),
                                     aruco::getPredefinedDictionary(dictionary.number));
}

// Whether corners span a plane rather than a line: the smaller of their spreads, against the square.
bool spread_both_ways(const std::vector<glm::dvec2>& corners, double square_m) {
  glm::dvec2 mean{0.0};
  for (const auto& at : corners) mean += at / static_cast<double>(corners.size());
  double xx = 0.0, xy = 0.0, yy = 0.0;
  for (const auto& at : corners) {
    const glm::dvec2 off = (at - mean) / square_m;
    xx += off.x * off.x;
    xy += off.x * off.y;
    yy += off.y * off.y;
  }
  const double smaller = 0.5 * (xx + yy) - std::hypot(0.5 * (xx - yy), xy);
  return smaller > 0.5;
}

// Refined in a window that excludes the markers, which would attract the corner.
void refine(const cv::Mat& picture, const CharucoBoard& board, const BoardView& view,
            std::vector<cv::Point2f>& corners) {
  double nearest_px = 1e9;
  for (std::size_t i = 0; i < corners.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      if (glm::distance(view.on_board[i], view.on_board[k]) < 1.01 * board.square_m)
        nearest_px = std::min(nearest_px, glm::distance(view.pixels[i], view.pixels[k]));
  if (nearest_px > 1e8) return;
  const double margin_px = 0.5 * (board.square_m - board.marker_m) / board.square_m * nearest_px;
  const int window = std::clamp(static_cast<int>(std::lround(margin_px)), 2, 11);
  cv::cornerSubPix(picture, corners, {window, window}, {-1, -1},
                   {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 50, 1e-3});
}

}  // namespace

std::vector<std::string> problems_of(const CharucoBoard& board) {
  std::vector<std::string> problems;
  if (board.columns < 3 || board.rows < 3 || board.columns > 100 || board.rows > 100)
    problems.push_back(fmt::format("--charuco {}x{}: expected 3 to 100 squares each way", board.columns, board.rows));
  if (!(board.square_m > 0.0)) problems.push_back("--square-mm: expected the side of a square, measured on the print");
  if (!(board.marker_m > 0.0 && board.marker_m < board.square_m))
    problems.push_back(fmt::format(
        "--marker-mm {}: expected the side of a marker, more than 0 and less than the square", 1e3 * board.marker_m));
  const auto* const dictionary = dictionary_of(board);
  std::vector<std::string_view> names;
  for (const auto& known : kDictionaries) names.push_back(known.name);
  if (!dictionary)
    problems.push_back(fmt::format("--dictionary {}: expected one of {}", board.dictionary, fmt::join(names, ", ")));
  else if (board.columns * board.rows / 2 > dictionary->markers)
    problems.push_back(
        fmt::format("--dictionary {}: {} markers, expected one with {} at least, as {} x {} squares need",
                    board.dictionary, dictionary->markers, board.columns * board.rows / 2, board.columns, board.rows));
  return problems;
}

std::optional<BoardView> find_charuco(const Image<std::uint8_t>& grey, const CharucoBoard& board,
                                      std::string name) try {
  constexpr std::size_t kFewestCorners = 6;
  if (!problems_of(board).empty() || grey.empty()) return std::nullopt;
  auto pixels = grey.elements();
  const cv::Mat picture(grey.height(), grey.width(), CV_8UC1, pixels.data());
  const auto layout = opencv_board(board, *dictionary_of(board));
  const auto how = aruco::DetectorParameters::create();
  how->minMarkerPerimeterRate = 0.01;       // a fisheye draws a board small
  how->polygonalApproxAccuracyRate = 0.06;  // and its edges bent
  std::vector<std::vector<cv::Point2f>> markers;
  std::vector<int> ids;
  aruco::detectMarkers(picture, layout->dictionary, markers, ids, how);
  if (ids.empty()) return std::nullopt;
  std::vector<cv::Point2f> corners;
  std::vector<int> corner_ids;
  // The lens is not known yet, so each corner is interpolated from the nearest markers and then refined.
  aruco::interpolateCornersCharuco(markers, ids, picture, layout, corners, corner_ids);
  BoardView view{std::move(name), {}, {}};
  view.clear_m = 0.5 * (board.square_m - board.marker_m);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const auto& at = layout->chessboardCorners[static_cast<std::size_t>(corner_ids[i])];
    view.pixels.emplace_back(corners[i].x, corners[i].y);
    view.on_board.emplace_back(at.x, at.y);
  }
  refine(picture, board, view, corners);
  for (std::size_t i = 0; i < corners.size(); ++i) view.pixels[i] = {corners[i].x, corners[i].y};
  if (view.pixels.size() < kFewestCorners || !spread_both_ways(view.on_board, board.square_m)) return std::nullopt;
  return view;
} catch (const cv::Exception&) {
  return std::nullopt;
}

std::vector<BlackBox> black_of(const Board& board) {
  std::vector<BlackBox> boxes;
  for (int y = 0; y <= board.rows; ++y)
    for (int x = 0; x <= board.columns; ++x)
      if ((x + y) % 2 == 0) boxes.push_back({board.square_m * glm::dvec2{x, y}, board.square_m});
  return boxes;
}

// OpenCV's own board, whatever the direction its y axis has: a marker's corners come clockwise from its top left.
std::vector<BlackBox> black_of(const CharucoBoard& board) {
  const auto layout = opencv_board(board, *dictionary_of(board));
  const auto point = [](const cv::Point3f& p) { return glm::dvec2{p.x, p.y}; };
  const auto& first = layout->objPoints.front();
  const bool y_up = first[3].y < first[0].y;
  const auto on_page = [&](glm::dvec2 at) {
    if (y_up) at.y = board.rows * board.square_m - at.y;
    return at;
  };
  Image<std::uint8_t> has_marker(board.columns, board.rows, 0);
  std::vector<BlackBox> boxes;
  for (std::size_t m = 0; m < layout->ids.size(); ++m) {
    const glm::dvec2 corner = on_page(point(layout->objPoints[m][0]));
    has_marker.at(static_cast<int>(corner.x / board.square_m), static_cast<int>(corner.y / board.square_m)) = 1;
    const int modules = layout->dictionary->markerSize + 2;
    cv::Mat marker;
    layout->dictionary->drawMarker(layout->ids[m], modules, marker, 1);
    const double side_m = board.marker_m / modules;
    for (int y = 0; y < modules; ++y)
      for (int x = 0; x < modules; ++x)
        if (marker.at<std::uint8_t>(y, x) == 0) boxes.push_back({corner + side_m * glm::dvec2{x, y}, side_m});
  }
  for (int y = 0; y < board.rows; ++y)
    for (int x = 0; x < board.columns; ++x)
      if (has_marker.at(x, y) == 0) boxes.push_back({board.square_m * glm::dvec2{x, y}, board.square_m});
  return boxes;
}

}  // namespace kasumi
