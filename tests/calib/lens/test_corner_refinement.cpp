// Corners near a fisheye's rim: where a finder puts them, and where they are.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <random>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "base/geometry.hpp"
#include "calib/board/corner_refinement.hpp"
#include "calib/lens/lens_calibration.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

constexpr int kWidth = 800, kHeight = 800;
constexpr Board kTarget{7, 5, 0.03};
const LensPtr kLens =
    opencv_fisheye_lens({250.0, 250.6}, {403.2, 396.1}, {-0.012, 0.004, -0.002, 0.0003}, from_degrees(100.0));

// The middle of the board `off_deg` from the axis, leaning against the line of sight.
BoardPose pose_of(double off_deg, double turn_deg, double lean_x, double lean_y, double away_m) {
  const double off = from_degrees(off_deg).value, turn = from_degrees(turn_deg).value;
  const glm::dvec3 towards{std::sin(off) * std::cos(turn), std::sin(off) * std::sin(turn), std::cos(off)};
  const glm::dvec3 up = std::abs(towards.y) < 0.8 ? glm::dvec3{0, 1, 0} : glm::dvec3{1, 0, 0};
  const glm::dvec3 right = glm::normalize(glm::cross(up, towards)), down = glm::cross(towards, right);
  const glm::dvec3 normal = glm::normalize(towards + lean_x * right + lean_y * down);
  const glm::dvec3 x = glm::normalize(glm::cross(down, normal)), y = glm::cross(normal, x);
  BoardPose pose{{x, y, normal}, {}};
  const glm::dvec3 middle = 0.5 * kTarget.square_m * glm::dvec3{kTarget.columns - 1.0, kTarget.rows - 1.0, 0.0};
  pose.translation_m = away_m * towards - pose.rotation * middle;
  return pose;
}

glm::dvec2 true_pixel(const BoardPose& pose, const glm::dvec2& on_board) {
  return kLens->project(pose.rotation * glm::dvec3(on_board, 0.0) + pose.translation_m).value_or(glm::dvec2{-1e3});
}

// With a white margin of a square, before a grey wall, through a lens that is a little soft, with the sensor's noise.
// Places on the board change so little within a pixel that they are interpolated there.
Image<std::uint8_t> drawn(const BoardPose& pose, std::uint64_t seed) {
  constexpr int kFine = 4;
  constexpr double kWall = 120.0, kWhite = 210.0, kBlack = 35.0;
  const auto level = [](const glm::dvec2& at) {
    const double u = std::floor(at.x), v = std::floor(at.y);
    if (u < -2 || v < -2 || u > kTarget.columns || v > kTarget.rows) return kWall;
    const bool margin = u < -1 || v < -1 || u == kTarget.columns || v == kTarget.rows;
    return !margin && std::fmod(u + v + 4.0, 2.0) == 0.0 ? kBlack : kWhite;
  };
  // In squares; far away where the lens or the board does not reach.
  const auto on_board = [&](const glm::dvec2& pixel) -> glm::dvec2 {
    const auto ray = kLens->unproject(pixel);
    const double along = ray ? glm::dot(pose.translation_m, pose.rotation[2]) / glm::dot(*ray, pose.rotation[2]) : 0.0;
    if (!(along > 0.0)) return glm::dvec2{1e3};
    const glm::dvec3 at = glm::transpose(pose.rotation) * (along * *ray - pose.translation_m) / kTarget.square_m;
    return {at.x, at.y};
  };
  glm::dvec2 lowest{1e9}, highest{-1e9};
  for (double u = -2.0; u <= kTarget.columns + 1.0; u += 0.5)
    for (double v = -2.0; v <= kTarget.rows + 1.0; v += 0.5) {
      const auto pixel = true_pixel(pose, kTarget.square_m * glm::dvec2{u, v});
      if (pixel.x < -100.0) continue;
      lowest = glm::min(lowest, pixel);
      highest = glm::max(highest, pixel);
    }
  const int left = std::max(0, static_cast<int>(lowest.x) - 2), top = std::max(0, static_cast<int>(lowest.y) - 2);
  const int right = std::min(kWidth - 1, static_cast<int>(highest.x) + 2),
            bottom = std::min(kHeight - 1, static_cast<int>(highest.y) + 2);
  cv::Mat picture(kHeight, kWidth, CV_32F, cv::Scalar(kWall));
  Image<glm::dvec2> corner(right - left + 2, bottom - top + 2);  // of the pixels
  for (int y = 0; y < corner.height(); ++y)
    for (int x = 0; x < corner.width(); ++x) corner.at(x, y) = on_board({left + x - 0.5, top + y - 0.5});
  for (int y = top; y <= bottom; ++y)
    for (int x = left; x <= right; ++x) {
      double sum = 0.0;
      for (int i = 0; i < kFine * kFine; ++i) {
        const double across = (i % kFine + 0.5) / kFine, down = (i / kFine + 0.5) / kFine;
        const auto above = glm::mix(corner.at(x - left, y - top), corner.at(x - left + 1, y - top), across),
                   below = glm::mix(corner.at(x - left, y - top + 1), corner.at(x - left + 1, y - top + 1), across);
        sum += level(glm::mix(above, below, down));
      }
      picture.at<float>(y, x) = static_cast<float>(sum / (kFine * kFine));
    }
  cv::GaussianBlur(picture, picture, {}, 0.6);
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0.0, 2.0);
  Image<std::uint8_t> grey(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      grey.at(x, y) = static_cast<std::uint8_t>(
          std::clamp(static_cast<double>(picture.at<float>(y, x)) + noise(random), 0.0, 255.0));
  return grey;
}

struct Taken {
  BoardPose pose;
  BoardView view;
};

// Ten views in the middle and at the rim, as a person takes them; those in which a board is found.
const std::vector<Taken>& taken_views() {
  static std::vector<Taken> all;
  if (!all.empty()) return all;
  int number = 0;
  for (const auto& [off, turn, x, y, away] : {std::array{5.0, 0.0, 0.3, 0.1, 0.26},
                                              {25.0, 80.0, -0.4, 0.3, 0.25},
                                              {30.0, 200.0, 0.3, -0.4, 0.25},
                                              {35.0, 320.0, -0.3, -0.3, 0.25},
                                              {52.0, 0.0, 0.2, 0.3, 0.21},
                                              {54.0, 90.0, -0.3, 0.1, 0.21},
                                              {56.0, 180.0, 0.1, -0.3, 0.21},
                                              {54.0, 270.0, 0.3, 0.2, 0.21},
                                              {58.0, 40.0, 0.2, 0.0, 0.22},
                                              {58.0, 130.0, -0.2, 0.2, 0.22},
                                              {56.0, 320.0, 0.1, 0.2, 0.21},
                                              {58.0, 220.0, 0.1, -0.1, 0.22}}) {
    const auto pose = pose_of(off, turn, x, y, away);
    const auto grey = drawn(pose, static_cast<std::uint64_t>(++number));
    auto view = find_board(grey, kTarget, fmt::format("view-{}", number));
    if (!view) continue;
    view->picture = std::make_shared<Image<std::uint8_t>>(grey);
    // The finder may have begun at the opposite corner.
    const auto n = view->pixels.size();
    if (glm::distance(view->pixels[0], true_pixel(pose, view->on_board[0])) >
        glm::distance(view->pixels[0], true_pixel(pose, view->on_board[n - 1])))
      std::reverse(view->pixels.begin(), view->pixels.end());
    all.push_back({pose, std::move(*view)});
  }
  return all;
}

// Root mean square of the corners' distances from where they are, `from_deg` off the axis and farther.
double rms_px(const std::vector<BoardView>& views, const std::vector<Taken>& truth, double from_deg) {
  double sum = 0.0;
  int count = 0;
  for (const auto& view : views) {
    const auto taken = std::ranges::find(truth, view.name, [](const Taken& t) { return t.view.name; });
    for (std::size_t i = 0; i < view.pixels.size(); ++i) {
      const auto at = true_pixel(taken->pose, view.on_board[i]);
      const auto ray = kLens->unproject(at);
      if (!ray || to_degrees(angle_between(*ray, {0, 0, 1})) < from_deg) continue;
      const double off = glm::distance(at, view.pixels[i]);
      sum += off * off;
      ++count;
    }
  }
  return std::sqrt(sum / std::max(1, count));
}

double largest_lens_error_px(const LensDescription& found, double reach_deg) {
  auto wide = found;
  wide.largest_angle = from_degrees(100.0);
  const auto lens = make_lens(wide);
  double largest = 0.0;
  for (double off = 0.0; off <= reach_deg; off += 5.0)
    for (double turn = 0.0; turn < 360.0; turn += 30.0) {
      const double t = from_degrees(off).value, p = from_degrees(turn).value;
      const glm::dvec3 ray{std::sin(t) * std::cos(p), std::sin(t) * std::sin(p), std::cos(t)};
      const auto a = lens->project(ray), b = kLens->project(ray);
      largest = std::max(largest, a && b ? glm::distance(*a, *b) : 1e9);
    }
  return largest;
}

TEST(CornerRefinement, PutsCornersAtTheRimWhereTheyAre) {
  const auto& taken = taken_views();
  ASSERT_GE(taken.size(), 10u);
  std::vector<BoardView> found, blind;
  for (const auto& one : taken) {
    found.push_back(one.view);
    blind.push_back(one.view);
    blind.back().picture.reset();
  }
  const LensCalibrationRequest options{.family = LensFamily::opencv_fisheye};
  const auto with = calibrate_lens(found, kWidth, kHeight, options);
  const auto without = calibrate_lens(blind, kWidth, kHeight, options);
  ASSERT_TRUE(with && without);
  const double before = rms_px(found, taken, 60.0), after = rms_px(with->views, taken, 60.0);
  std::printf("%zu views; corners beyond 60 deg %.3f px off as found, %.3f px located again\n", found.size(), before,
              after);
  std::printf("without: %zu views, rms %.3f px, lens %.3f px off; with: %zu, %.3f px, %.3f px\n", without->views.size(),
              without->fit.rms_px, largest_lens_error_px(without->fit.lens, 75.0), with->views.size(), with->fit.rms_px,
              largest_lens_error_px(with->fit.lens, 75.0));
  EXPECT_TRUE(with->dropped.empty());
  EXPECT_LE(after, 0.9 * before);
  EXPECT_LE(after, 0.07);
  const double bent = largest_lens_error_px(without->fit.lens, 75.0),
               lens = largest_lens_error_px(with->fit.lens, 75.0);
  EXPECT_LE(lens, 0.12);
  EXPECT_LE(lens, 0.7 * bent) << "what the finder does alike in all views bends the lens";
}

// Every third corner of a view found some pixels off costs no view.
TEST(CornerRefinement, MendsWhatTheFinderGotWrongBeforeAnyViewIsDropped) {
  const auto& taken = taken_views();
  std::vector<BoardView> found;
  for (const auto& one : taken) found.push_back(one.view);
  for (std::size_t corner = 0; corner < found[4].pixels.size(); corner += 3)
    found[4].pixels[corner] += glm::dvec2{2.5, -2.0};
  const auto calibrated = calibrate_lens(found, kWidth, kHeight, {.family = LensFamily::opencv_fisheye});
  ASSERT_TRUE(calibrated);
  EXPECT_TRUE(calibrated->dropped.empty());
  EXPECT_LE(calibrated->fit.rms_px, 0.1);
}

TEST(CornerRefinement, LeavesCornersThatAreNotThere) {
  const auto& taken = taken_views();
  BoardView view = taken[0].view;
  const auto shown = [&](const glm::dvec2& at) { return std::optional(true_pixel(taken[0].pose, at)); };
  view.picture = std::make_shared<Image<std::uint8_t>>(kWidth, kHeight, 90);
  auto blank = view;
  refine_corners(blank, shown);
  EXPECT_EQ(blank.pixels, view.pixels) << "nothing to be seen";
  view.picture.reset();
  auto unseen = view;
  refine_corners(unseen, [](const glm::dvec2&) { return std::optional(glm::dvec2{5.0}); });
  EXPECT_EQ(unseen.pixels, view.pixels);
  auto outside = taken[0].view;
  refine_corners(outside, [](const glm::dvec2&) { return std::optional<glm::dvec2>(); });
  EXPECT_EQ(outside.pixels, taken[0].view.pixels);
}

}  // namespace
}  // namespace kasumi
