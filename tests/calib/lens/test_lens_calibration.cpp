// Lenses calibrated from pictures of a board: known lenses, and one with a published calibration.
#include <algorithm>
#include <filesystem>
#include <random>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "base/geometry.hpp"
#include "calib/lens/lens_calibration.hpp"
#include "tests/calib/lens/boards.hpp"
#include "tests/calib/lens/lenses.hpp"
#include "tests/must.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

double uniform(std::mt19937_64& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
}
double normal(std::mt19937_64& random) {
  double sum = -6.0;
  for (int i = 0; i < 12; ++i) sum += uniform(random, 0.0, 1.0);
  return sum;
}

constexpr Board kBoard{8, 6, 0.03};

// A board anywhere in the lens's view, tilted by up to 40 deg against the line of sight.
BoardPose some_pose(std::mt19937_64& random, double largest_off_axis, double away_m) {
  const double off = largest_off_axis * std::sqrt(uniform(random, 0.0, 1.0)), turn = uniform(random, 0.0, 2.0 * kPi);
  const glm::dvec3 towards{std::sin(off) * std::cos(turn), std::sin(off) * std::sin(turn), std::cos(off)};
  const auto tilt = [&] { return uniform(random, -0.7, 0.7); };
  const glm::dvec3 normal_of_board = glm::normalize(towards + glm::dvec3{tilt(), tilt(), 0.0});
  const double roll = uniform(random, 0.0, 2.0 * kPi);
  const glm::dvec3 any{std::cos(roll), std::sin(roll), 0.1};
  const glm::dvec3 x = glm::normalize(glm::cross(normal_of_board, any)), y = glm::cross(normal_of_board, x);
  const glm::dvec3 middle = 0.5 * kBoard.square_m * glm::dvec3{kBoard.columns - 1.0, kBoard.rows - 1.0, 0.0};
  BoardPose pose{{x, y, normal_of_board}, {}};
  pose.translation_m = away_m * towards - pose.rotation * middle;
  return pose;
}

std::optional<BoardView> view_of_board(const Lens& lens, int width, int height, const BoardPose& pose,
                                       const std::string& name) {
  BoardView view{name, {}, {}};
  for (int row = 0; row < kBoard.rows; ++row)
    for (int column = 0; column < kBoard.columns; ++column) {
      const glm::dvec2 at = kBoard.square_m * glm::dvec2{column, row};
      const auto pixel = lens.project(pose.rotation * glm::dvec3(at, 0.0) + pose.translation_m);
      if (!pixel || pixel->x < 0 || pixel->y < 0 || pixel->x > width - 1 || pixel->y > height - 1) return std::nullopt;
      view.pixels.push_back(*pixel);
      view.on_board.push_back(at);
    }
  return view;
}

std::vector<BoardView> views_of(const SampleLens& sample, int count, double noise_px, double away_m,
                                std::uint64_t seed = 1) {
  std::mt19937_64 random(seed);
  std::vector<BoardView> views;
  while (static_cast<int>(views.size()) < count) {
    auto view = view_of_board(*sample.lens, sample.width, sample.height, some_pose(random, 1.1, away_m),
                              fmt::format("view-{}.png", views.size()));
    if (!view) continue;
    for (auto& pixel : view->pixels) pixel += noise_px * glm::dvec2{normal(random), normal(random)};
    views.push_back(std::move(*view));
  }
  return views;
}

// Largest distance in pixels between two lenses over their common view within an angle from the axis.
double largest_difference_px(const Lens& a, const Lens& b, double reach_deg) {
  double largest = 0.0;
  for (double off = 0.0; off <= reach_deg; off += 5.0)
    for (double turn = 0.0; turn < 360.0; turn += 30.0) {
      const double t = from_degrees(off).value, p = from_degrees(turn).value;
      const glm::dvec3 ray{std::sin(t) * std::cos(p), std::sin(t) * std::sin(p), std::cos(t)};
      const auto at = a.project(ray), bt = b.project(ray);
      if (!at || !bt) return 1e9;
      largest = std::max(largest, glm::distance(*at, *bt));
    }
  return largest;
}

const SampleLens kFisheye{"opencv_fisheye",
                          opencv_fisheye_lens({336.8, 337.9}, {543.4, 377.7}, kSampleFisheye, from_degrees(110.0)),
                          1032, 778};
const SampleLens kScaramuzza{
    "scaramuzza",
    scaramuzza_lens(
        {{-551.7655, 0.0, 8.372454e-4, -6.474789e-7, 1.235631e-9}, {505.48, 381.78}, 1.003, 1.5e-3, 0.0, 1024, 768},
        from_degrees(110.0)),
    1024, 768};
const SampleLens kPinhole{"pinhole", pinhole_lens(sample_pinhole()), 1920, 1080};

TEST(BoardPose, IsFoundFromRaysAlone) {
  std::mt19937_64 random(5);
  for (int i = 0; i < 20; ++i) {
    const auto pose = some_pose(random, 1.4, 0.4);
    std::vector<glm::dvec3> rays;
    std::vector<glm::dvec2> on_board;
    for (int corner = 0; corner < 12; ++corner) {
      on_board.push_back(kBoard.square_m * glm::dvec2{corner % 4, corner / 4});
      rays.push_back(glm::normalize(pose.rotation * glm::dvec3(on_board.back(), 0.0) + pose.translation_m));
    }
    const auto found = must(board_pose(rays, on_board));
    EXPECT_LE(glm::length(found->translation_m - pose.translation_m), 1e-9);
    for (int axis = 0; axis < 3; ++axis) EXPECT_LE(glm::length(found->rotation[axis] - pose.rotation[axis]), 1e-9);
  }
}

TEST(BoardPose, CollinearCornersAreRefused) {
  const std::vector<glm::dvec2> line{{0, 0}, {1, 0}, {2, 0}, {3, 0}, {4, 0}};
  std::vector<glm::dvec3> rays;
  for (const auto& at : line) rays.push_back(glm::normalize(glm::dvec3{at.x - 2.0, 0.3, 5.0}));
  EXPECT_FALSE(board_pose(rays, line));
}

TEST(LensFit, ExactCornersRecoverTheLens) {
  for (const auto& [sample, family, away_m] :
       {std::tuple{kFisheye, LensFamily::opencv_fisheye, 0.25}, std::tuple{kScaramuzza, LensFamily::scaramuzza, 0.25},
        std::tuple{kPinhole, LensFamily::pinhole, 0.6}}) {
    const auto fit = fit_lens(family, views_of(sample, 12, 0.0, away_m), sample.width, sample.height);
    ASSERT_TRUE(fit) << sample.what;
    EXPECT_LE(fit->rms_px, 1e-4) << sample.what;
    const double reach = std::min(60.0, to_degrees(fit->lens.largest_angle) - 2.0);
    EXPECT_LE(largest_difference_px(*make_lens(fit->lens), *sample.lens, std::floor(reach)), 0.02) << sample.what;
  }
}

TEST(LensCalibration, TheRightModelIsChosenAndItsErrorIsAsReported) {
  for (const auto& [sample, away_m] : {std::pair{kFisheye, 0.25}, std::pair{kPinhole, 0.6}}) {
    const auto found = must(calibrate_lens(views_of(sample, 12, 0.3, away_m), sample.width, sample.height));
    EXPECT_EQ(model_name(found->fit.lens), sample.what);
    EXPECT_TRUE(found->dropped.empty());
    EXPECT_NEAR(found->fit.rms_px, 0.3 * std::sqrt(2.0), 0.04);
    ASSERT_TRUE(found->fit.sigma);
    const auto truth = sample.lens->project({0, 0, 1}).value();
    const auto off = glm::abs(centre_of(found->fit.lens) - truth);
    EXPECT_LE(off.x, 4.0 * found->fit.sigma->centre_px.x);
    EXPECT_LE(off.y, 4.0 * found->fit.sigma->centre_px.y);
    EXPECT_LE(found->fit.sigma->centre_px.x, 0.005 * sample.width);
  }
}

TEST(LensCalibration, AnOutlierViewIsDroppedByName) {
  auto views = views_of(kFisheye, 12, 0.2, 0.25);
  std::mt19937_64 random(3);
  for (auto& pixel : views[7].pixels) pixel += 4.0 * glm::dvec2{normal(random), normal(random)};
  views[7].name = "moved-while-taken.jpg";
  const auto found =
      must(calibrate_lens(views, kFisheye.width, kFisheye.height, {.family = LensFamily::opencv_fisheye}));
  ASSERT_EQ(found->dropped.size(), 1u);
  EXPECT_EQ(found->dropped[0].name, "moved-while-taken.jpg");
  EXPECT_THAT(found->dropped[0].reason, HasSubstr("px off"));
  EXPECT_NEAR(found->fit.rms_px, 0.2 * std::sqrt(2.0), 0.03);
}

TEST(LensCalibration, ParametersThePicturesDoNotFixAreReported) {
  std::vector<BoardView> views;  // straight ahead in the upper left, never tilted
  for (int i = 0; i < 5; ++i) {
    BoardPose pose;
    pose.translation_m = {-0.3 + 0.01 * i, -0.25, 0.30 + 0.01 * i};
    views.push_back(view_of_board(*kFisheye.lens, kFisheye.width, kFisheye.height, pose, "p").value());
    std::mt19937_64 random(static_cast<std::uint64_t>(i));
    for (auto& pixel : views.back().pixels) pixel += 0.1 * glm::dvec2{normal(random), normal(random)};
  }
  const auto found =
      must(calibrate_lens(views, kFisheye.width, kFisheye.height, {.family = LensFamily::opencv_fisheye}));
  const auto advice = fmt::format("{}", fmt::join(found->coverage.advice, "\n"));
  EXPECT_THAT(advice, HasSubstr("lower right"));
  EXPECT_THAT(advice, HasSubstr("tilt the board"));
  EXPECT_THAT(advice, HasSubstr("5 views are few"));
  EXPECT_LT(found->coverage.covered, 0.4);

  EXPECT_FALSE(calibrate_lens({views[0], views[1]}, kFisheye.width, kFisheye.height));
}

TEST(Board, CornersOfADrawnBoardAreFoundWithinAFifthOfAPixel) {
  const auto lens = equidistant_lens({199.5, 149.5}, 130.0, from_degrees(90.0));
  BoardPose pose;
  pose.rotation = glm::dmat3{{0.96, 0.1, 0.26}, {-0.1, 0.995, 0.0}, {0, 0, 1}};
  pose.rotation[0] = glm::normalize(pose.rotation[0]);
  pose.rotation[1] = glm::normalize(pose.rotation[1] - glm::dot(pose.rotation[0], pose.rotation[1]) * pose.rotation[0]);
  pose.rotation[2] = glm::cross(pose.rotation[0], pose.rotation[1]);
  pose.translation_m = {-0.11, -0.07, 0.2};
  const auto picture = picture_of_board(*lens, 400, 300, kBoard, pose, 6);
  const auto view = must(find_board(picture, kBoard, "drawn"));
  const auto truth = view_of_board(*lens, 400, 300, pose, "").value();
  // The board may have been found rotated by 180 degrees.
  double forwards = 0.0, backwards = 0.0;
  for (std::size_t i = 0; i < truth.pixels.size(); ++i) {
    forwards = std::max(forwards, glm::distance(view->pixels[i], truth.pixels[i]));
    backwards = std::max(backwards, glm::distance(view->pixels[i], truth.pixels[truth.pixels.size() - 1 - i]));
  }
  EXPECT_LE(std::min(forwards, backwards), 0.2);
  EXPECT_FALSE(find_board(Image<std::uint8_t>(400, 300, 90), kBoard, "blank"));
}

TEST(LensCalibration, APublishedFisheyeCalibrationIsReproduced) {
  const auto folder = shared_data_folder() / "fisheye/fish-1";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no sample data at " << folder;
  std::vector<BoardView> views;
  for (int i = 1; i <= 15; ++i) {
    const auto name = fmt::format("Fisheye1_{}.jpg", i);
    const auto picture = cv::imread((folder / name).string(), cv::IMREAD_GRAYSCALE);
    ASSERT_FALSE(picture.empty());
    Image<std::uint8_t> grey(picture.cols, picture.rows);
    for (int y = 0; y < picture.rows; ++y) std::copy_n(picture.ptr<std::uint8_t>(y), picture.cols, grey.row(y));
    if (auto view = find_board(grey, {6, 8, 1.0}, name)) views.push_back(std::move(*view));
  }
  EXPECT_GE(views.size(), 13u);
  const auto found = must(calibrate_lens(views, 1032, 778));
  for (const auto& candidate : found->candidates)
    std::printf("%s: %.3f px\n", std::string(name_of(candidate.family)).c_str(),
                candidate.held_out_rms_px.value_or(-1.0));
  for (const auto& dropped : found->dropped)
    std::printf("dropped %s: %s\n", dropped.name.c_str(), dropped.reason.c_str());
  std::printf("%s, %zu views, rms %.3f px, focal %.2f +- %.2f px, centre (%.2f, %.2f)\n",
              std::string(model_name(found->fit.lens)).c_str(), found->views.size(), found->fit.rms_px,
              focal_px_of(found->fit.lens), found->fit.sigma->focal_px, centre_of(found->fit.lens).x,
              centre_of(found->fit.lens).y);
  EXPECT_LE(found->fit.rms_px, 0.67);
  // Published (py-OCamCalib): a0 = 337.717 px along columns, 337.717 x 1.0033 along rows, centre (543.99, 377.65).
  EXPECT_NEAR(focal_px_of(found->fit.lens), 337.717, 0.005 * 337.717);
  EXPECT_LE(glm::distance(centre_of(found->fit.lens), {543.99, 377.65}), 1.5);
}

}  // namespace
}  // namespace kasumi
