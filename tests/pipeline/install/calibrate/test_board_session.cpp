// kasumi calibrate lens with a live camera: which views are accepted, the guidance given, when it ends.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <opencv2/imgproc.hpp>

#include "calib/board/board_collector.hpp"
#include "calib/lens/lens_fit.hpp"
#include "pipeline/install/calibrate/board_window.hpp"
#include "tests/calib/lens/boards.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/install/calibrate/calibrating.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;
using Found = BoardCollector::Found;

constexpr Board kBoard{6, 4, 0.03};
constexpr int kWidth = 400, kHeight = 300;
const LensPtr kLens = equidistant_lens({201.0, 148.5}, 130.0, from_degrees(90.0));

// Beyond 75 deg the lens transmits no light.
Image<std::uint8_t> picture(const BoardPose& pose) {
  auto made = picture_of_board(*kLens, kWidth, kHeight, kBoard, pose, 3);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      if (glm::distance(glm::dvec2{x, y}, {201.0, 148.5}) > 170.0) made.at(x, y) = 3;
  return made;
}

BoardPose pose_at(double right_m, double down_m, double tilt_x, double tilt_y) {
  return board_at(kBoard, right_m, down_m, tilt_x, tilt_y);
}

TEST(BoardCollector, AcceptsAViewThatIsStillSharpAndNew) {
  BoardCollector collector(kBoard);
  const auto here = picture(pose_at(0.0, 0.0, 0.0, 0.0)), there = picture(pose_at(0.02, 0.0, 0.0, 0.0));
  EXPECT_EQ(collector.look(Image<std::uint8_t>(kWidth, kHeight, 90), "a"), Found::nothing);
  EXPECT_EQ(collector.look(here, "b"), Found::moving);  // not yet known to stand still
  EXPECT_EQ(collector.look(there, "c"), Found::moving);
  Image<std::uint8_t> soft = there;
  cv::Mat blurred(kHeight, kWidth, CV_8UC1, soft.elements().data());
  cv::GaussianBlur(blurred, blurred, {0, 0}, 3.5);
  EXPECT_EQ(collector.look(soft, "d"), Found::blurred);
  EXPECT_EQ(collector.look(there, "e"), Found::taken);
  EXPECT_EQ(collector.look(there, "f"), Found::known);
  ASSERT_EQ(collector.views().size(), 1u);
  EXPECT_EQ(collector.views()[0].name, "e");
  EXPECT_FALSE(collector.enough());
}

TEST(BoardCollector, ReportsMissingPositionsAndTilts) {
  BoardCollector collector(kBoard);
  const auto take = [&](const BoardPose& pose) {
    const auto frame = picture(pose);
    collector.look(frame, "");
    return collector.look(frame, "");
  };
  EXPECT_EQ(take(pose_at(-0.13, -0.07, 0.0, 0.0)), Found::taken);
  // The board's normal points away from the camera: (.6, 0, 1) has its right side farther away.
  EXPECT_EQ(take(pose_at(0.0, 0.0, 0.6, 0.0)), Found::taken);
  EXPECT_TRUE(collector.leaned(Lean::right) != collector.leaned(Lean::left));
  EXPECT_EQ(take(pose_at(0.0, 0.0, -0.6, 0.0)), Found::taken);
  EXPECT_TRUE(collector.leaned(Lean::right) && collector.leaned(Lean::left));
  EXPECT_FALSE(collector.leaned(Lean::top) || collector.leaned(Lean::bottom));
  EXPECT_THAT(collector.advice(),
              testing::ContainsRegex("move the board to the .* and tilt it, its upper side nearer"));
  // The corners of the picture are dark, the middle was covered, the lower right was not.
  EXPECT_EQ(collector.cell(0, 0), BoardCollector::Cell::dark);
  EXPECT_EQ(collector.cell(3, 3), BoardCollector::Cell::covered);
  EXPECT_EQ(collector.cell(4, 4), BoardCollector::Cell::bare);
  // The window shows this in green and red.
  const auto shown = draw_coverage(picture(pose_at(0.0, 0.0, 0.0, 0.0)), collector, "words");
  const auto& covered = shown.at(3 * 160 + 80, 34 + 3 * 120 + 8);
  EXPECT_GT(covered.g, covered.r);
}

TEST(BoardCollector, TheNearerSideIsTheOneWithLargerSquares) {
  BoardCollector collector(kBoard);
  // Independent of the normal's sign: compare the sizes of the squares as drawn.
  const auto pose = pose_at(0.0, 0.0, 0.6, 0.0);
  const auto size_at = [&](double x) {
    const auto a = kLens->project(pose.rotation * glm::dvec3{x, 0.0, 0.0} + pose.translation_m).value();
    const auto b = kLens->project(pose.rotation * glm::dvec3{x, 0.09, 0.0} + pose.translation_m).value();
    return std::pair(a.x, glm::distance(a, b));
  };
  const auto one = size_at(0.0), other = size_at(0.15);
  const bool right_larger = (one.first > other.first) == (one.second > other.second);
  const auto frame = picture(pose);
  collector.look(frame, "");
  ASSERT_EQ(collector.look(frame, ""), Found::taken);
  EXPECT_TRUE(collector.leaned(right_larger ? Lean::right : Lean::left));
}

TEST(CalibrateLens, ARecordingInACamerasPlaceIsReadUntilThePictureIsCovered) {
  const auto folder = fresh_folder("calibrate-live"), sky = folder / "sky";
  std::filesystem::create_directories(sky);
  std::string index = "monotonic_ns,utc,sequence,fourcc,width,height,stride,bytes_used,exposure_s,gain,flags,payload\n";
  int rows = 0;
  const auto row = [&](const std::string& payload, const char* flags) {
    index += fmt::format("{},2026-06-21T09:00:{:02}.{:03}Z,{},GREY,{},{},{},{},,,{},{}\n", 100'000'000ll * rows,
                         rows / 10, 100 * (rows % 10), rows, kWidth, kHeight, kWidth, kWidth * kHeight, flags, payload);
    ++rows;
  };
  const auto frame = [&](const BoardPose& pose, int times) {
    const auto name = fmt::format("{}.raw", rows);
    const auto made = picture(pose);
    ASSERT_TRUE(write_file(sky / name, made.elements()));
    for (int i = 0; i < times; ++i) row(name, "");
  };
  row("", "error");
  for (const auto& tilt : {glm::dvec2{0.6, 0.0}, glm::dvec2{-0.6, 0.0}, glm::dvec2{0.0, 0.6}, glm::dvec2{0.0, -0.6}})
    frame(pose_at(0.0, 0.0, tilt.x, tilt.y), 2);
  for (const double down : {-0.16, -0.06, 0.06, 0.16})
    for (const double right : {-0.22, -0.08, 0.08, 0.22})
      frame(pose_at(right, down, 1.2 * right + 0.2, 1.2 * down - 0.2), 2);
  for (const auto& at :
       {glm::dvec2{-0.05, -0.2}, glm::dvec2{0.06, -0.2}, glm::dvec2{-0.05, 0.2}, glm::dvec2{0.06, 0.2}})
    frame(pose_at(at.x, at.y, 0.0, 1.5 * at.y), 2);
  for (int again = 0; again < 3; ++again) frame(pose_at(0.01 * again, 0.0, 0.0, 0.0), 2);
  ASSERT_TRUE(write_text_file(sky / "index.csv", index));

  const auto file = folder / "calibration.toml";
  const auto outcome =
      run(fmt::format("lens --live {} --board 6x4 --model opencv_fisheye --out {}", folder.string(), file.string()));
  std::printf("%s", outcome.out.c_str());
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("move the board to the"));
  EXPECT_THAT(outcome.out, HasSubstr("view 1 taken"));
  EXPECT_THAT(outcome.out, HasSubstr("the picture is covered"));  // before the recording was over
  const auto root = ConfigTable::read_file(file).value();
  const auto found = read_lens(root.table("sky").table("lens"));
  for (const double off : {0.0, 20.0, 40.0}) {
    const double angle = from_degrees(off).value;
    const glm::dvec3 ray{0.6 * std::sin(angle), 0.8 * std::sin(angle), std::cos(angle)};
    EXPECT_LE(glm::distance(found->project(ray).value(), kLens->project(ray).value()), 1.0) << off;
  }
}

TEST(CalibrateLens, AllProblemsOfALiveSessionAreReportedAtOnce) {
  const auto outcome = ended(2, run("lens a.png --live /nowhere/at-all --charuco 2x2 --out /nowhere/c.toml"));
  EXPECT_THAT(outcome.err, HasSubstr("expected one of pictures, --config, --live and --import"));
  EXPECT_THAT(outcome.err, HasSubstr("--charuco 2x2"));
  EXPECT_THAT(ended(2, run("lens --live /nowhere/at-all --board 8x6 --out /nowhere/c.toml")).err,
              HasSubstr("--size (none): expected the size"));
}

}  // namespace
}  // namespace kasumi
