// ChArUco boards drawn through known lenses, fully and partly visible.
#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "calib/board/charuco.hpp"
#include "calib/lens/lens_calibration.hpp"
#include "tests/calib/lens/lenses.hpp"
#include "tests/must.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

const CharucoBoard kBoard{8, 6, 0.03, 0.022, "DICT_4X4_50"};

// The board at 20 points a square, as black_of prints it.
Image<float> printed() {
  constexpr int kFine = 40;
  Image<float> page(kBoard.columns * kFine, kBoard.rows * kFine, 1.0f);
  for (const auto& box : black_of(kBoard)) {
    const auto at = [&](double m) { return static_cast<int>(std::lround(m / kBoard.square_m * kFine)); };
    for (int y = at(box.corner_m.y); y < at(box.corner_m.y + box.side_m); ++y)
      for (int x = at(box.corner_m.x); x < at(box.corner_m.x + box.side_m); ++x) page.at(x, y) = 0.0f;
  }
  return page;
}

// Tilted against the line of sight; the board's centre lies in direction `towards`.
BoardPose pose_at(const glm::dvec3& towards, double away_m, double tilt_x, double tilt_y) {
  const glm::dvec3 normal = glm::normalize(glm::normalize(towards) + glm::dvec3{tilt_x, tilt_y, 0.0});
  const glm::dvec3 x = glm::normalize(glm::cross(glm::dvec3{0.1, 1, 0}, normal)), y = glm::cross(normal, x);
  BoardPose pose{{x, y, normal}, {}};
  const glm::dvec3 middle = 0.5 * kBoard.square_m * glm::dvec3{kBoard.columns, kBoard.rows, 0.0};
  pose.translation_m = away_m * glm::normalize(towards) - pose.rotation * middle;
  return pose;
}

Image<std::uint8_t> picture(const Lens& lens, int width, int height, const BoardPose& pose, const Image<float>& page) {
  constexpr double kGround = 150.0, kMargin = 0.3;  // of a square
  // In squares from the board's corner; empty where it is not.
  const auto on_board = [&](const glm::dvec2& pixel, double margin) -> std::optional<glm::dvec2> {
    const auto ray = lens.unproject(pixel);
    if (!ray) return std::nullopt;
    const double along = glm::dot(pose.translation_m, pose.rotation[2]) / glm::dot(*ray, pose.rotation[2]);
    const glm::dvec3 at = glm::transpose(pose.rotation) * (along * *ray - pose.translation_m) / kBoard.square_m;
    if (!(along > 0.0 && at.x > -margin && at.y > -margin && at.x < kBoard.columns + margin &&
          at.y < kBoard.rows + margin))
      return std::nullopt;
    return glm::dvec2(at);
  };
  Image<std::uint8_t> made(width, height, static_cast<std::uint8_t>(kGround));
  constexpr int kRays = 4;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      if (!on_board({x, y}, 1.0)) continue;
      double sum = 0.0;
      for (int i = 0; i < kRays * kRays; ++i) {
        const auto at = on_board({x + (i % kRays + 0.5) / kRays - 0.5, y + (i / kRays + 0.5) / kRays - 0.5}, kMargin);
        const int u = at ? static_cast<int>(std::floor(at->x * 40.0)) : 0;
        const int v = at ? static_cast<int>(std::floor(at->y * 40.0)) : 0;
        sum += !at ? kGround : page.contains(u, v) ? 25.0 + 205.0 * static_cast<double>(page.at(u, v)) : 230.0;
      }
      made.at(x, y) = static_cast<std::uint8_t>(std::lround(sum / (kRays * kRays)));
    }
  return made;
}

// Largest distance of the detected corners from where the lens shows them. The inner corners are matched as a lattice,
// whichever end the board's numbering begins at.
double worst_px(const Lens& lens, const BoardPose& pose, const BoardView& view) {
  double worst = 0.0;
  for (const auto& pixel : view.pixels) {
    double nearest = 1e9;
    for (int y = 1; y < kBoard.rows; ++y)
      for (int x = 1; x < kBoard.columns; ++x) {
        const auto at = lens.project(pose.rotation * (kBoard.square_m * glm::dvec3{x, y, 0.0}) + pose.translation_m);
        if (at) nearest = std::min(nearest, glm::distance(*at, pixel));
      }
    worst = std::max(worst, nearest);
  }
  return worst;
}

TEST(Charuco, CornersAreFoundEvenOnAPartlyVisibleBoard) {
  const auto lens = equidistant_lens({319.5, 239.5}, 200.0, from_degrees(90.0));
  const auto page = printed();
  const auto whole = pose_at({0.05, -0.02, 1.0}, 0.26, 0.2, 0.1);
  const auto all = must(find_charuco(picture(*lens, 640, 480, whole, page), kBoard, "whole"));
  EXPECT_GE(all->pixels.size(), 30u);  // of 7 x 5
  EXPECT_LE(worst_px(*lens, whole, *all), 0.3);

  // Half of it lies outside the picture, where findChessboardCorners finds nothing.
  const auto aside = pose_at({-1.5, 0.1, 0.35}, 0.22, 0.1, 0.0);
  const auto cut = picture(*lens, 640, 480, aside, page);
  const auto part = must(find_charuco(cut, kBoard, "part"));
  EXPECT_GE(part->pixels.size(), 6u);
  EXPECT_LT(part->pixels.size(), 35u);
  EXPECT_LE(worst_px(*lens, aside, *part), 0.5);
  EXPECT_FALSE(find_board(cut, {7, 5, 0.03}, "checkerboard"));

  EXPECT_FALSE(find_charuco(Image<std::uint8_t>(320, 240, 128), kBoard, "blank"));
}

TEST(Charuco, PartialViewsOfABoardRecoverTheLens) {
  struct Case {
    LensPtr lens;
    LensFamily family;
    double reach, away_m;
  };
  const auto page = printed();
  for (const auto& [lens, family, reach, away_m] :
       {Case{equidistant_lens({321.0, 238.0}, 190.0, from_degrees(90.0)), LensFamily::opencv_fisheye, 1.15, 0.24},
        Case{pinhole_lens({{520.0, 522.0}, {322.0, 236.0}, {-0.12, 0.03, 0, 0, 0}}), LensFamily::pinhole, 0.5, 0.45}}) {
    std::vector<BoardView> views;
    int partly = 0;
    for (int i = 0; i < 12; ++i) {
      const double turn = 2.4 * i, off = reach * std::sqrt((i + 0.5) / 12.0);
      const auto pose = pose_at({std::sin(off) * std::cos(turn), std::sin(off) * std::sin(turn), std::cos(off)}, away_m,
                                0.45 * std::cos(1.7 * i), 0.45 * std::sin(2.9 * i));
      auto view = find_charuco(picture(*lens, 640, 480, pose, page), kBoard, fmt::format("view {}", i));
      if (!view) continue;
      if (view->pixels.size() < 35) ++partly;
      views.push_back(std::move(*view));
    }
    ASSERT_GE(views.size(), 9u);
    EXPECT_GE(partly, 1);
    LensCalibrationRequest options;
    options.family = family;
    const auto found = must(calibrate_lens(views, 640, 480, options));
    const auto fitted = make_lens(found->fit.lens);
    double worst = 0.0;
    for (double off = 0.0; off <= std::min(reach, 0.9 * to_degrees(found->coverage.farthest) * kPi / 180.0); off += 0.1)
      for (double turn = 0.0; turn < 6.2; turn += 0.5) {
        const glm::dvec3 ray{std::sin(off) * std::cos(turn), std::sin(off) * std::sin(turn), std::cos(off)};
        const auto a = lens->project(ray), b = fitted->project(ray);
        if (a && b && a->x > 0 && a->y > 0 && a->x < 639 && a->y < 479) worst = std::max(worst, glm::distance(*a, *b));
      }
    std::printf("%s: %zu views, %d in part, rms %.3f px, the lens off by %.2f px at worst\n",
                std::string(model_name(found->fit.lens)).c_str(), views.size(), partly, found->fit.rms_px, worst);
    EXPECT_LE(found->fit.rms_px, 0.35);
    EXPECT_LE(worst, 1.2);
  }
}

TEST(Charuco, AllProblemsOfABoardAreReportedAtOnce) {
  auto board = kBoard;
  EXPECT_TRUE(problems_of(board).empty());
  board.columns = 40;
  board.marker_m = 0.04;
  const auto problems = problems_of(board);
  ASSERT_EQ(problems.size(), 2u);
  EXPECT_THAT(problems[0], HasSubstr("--marker-mm 40"));
  EXPECT_THAT(problems[1], HasSubstr("50 markers, expected one with 120"));
  board.dictionary = "DICT_9X9";
  EXPECT_THAT(problems_of(board).back(), HasSubstr("--dictionary DICT_9X9: expected one of DICT_4X4_50"));
}

}  // namespace
}  // namespace kasumi
