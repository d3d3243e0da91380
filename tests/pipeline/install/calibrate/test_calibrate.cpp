// kasumi calibrate, from pictures to the file that estimate reads.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "base/files.hpp"
#include "calib/calibration_file.hpp"
#include "calib/lens/lens_fit.hpp"
#include "pipeline/site/config/fixture_file.hpp"
#include "pipeline/site/files/picture_sink.hpp"
#include "tests/calib/lens/boards.hpp"
#include "tests/pipeline/install/calibrate/calibrating.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

constexpr Board kPrintedBoard{7, 5, 0.03};
constexpr int kPictureWidth = 400, kPictureHeight = 300;

Image<Rgb8> rgb(const Image<std::uint8_t>& grey) {
  Image<Rgb8> picture(grey.width(), grey.height());
  std::ranges::transform(grey.elements(), picture.elements().begin(), [](std::uint8_t value) { return Rgb8(value); });
  return picture;
}

BoardPose printed_board_at(double right_m, double down_m, double tilt_x, double tilt_y) {
  return board_at(kPrintedBoard, right_m, down_m, tilt_x, tilt_y);
}

TEST(CalibrateLens, PicturesOfABoardBecomeACalibrationFile) {
  const auto folder = fresh_folder("calibrate-lens");
  const auto lens = equidistant_lens({203.0, 147.5}, 130.0, from_degrees(90.0));
  const std::vector poses{printed_board_at(0.0, 0.0, 0.3, 0.2),     printed_board_at(-0.12, -0.06, -0.4, 0.1),
                          printed_board_at(0.12, -0.06, 0.4, -0.3), printed_board_at(-0.12, 0.06, -0.2, 0.4),
                          printed_board_at(0.12, 0.06, 0.1, 0.4),   printed_board_at(0.02, 0.05, -0.5, -0.2)};
  std::string files;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const auto file = folder / fmt::format("board-{}.png", i);
    ASSERT_TRUE(
        write_png(file, rgb(picture_of_board(*lens, kPictureWidth, kPictureHeight, kPrintedBoard, poses[i], 4))));
    files += " " + file.string();
  }
  const auto file = folder / "calibration.toml";
  const auto outcome =
      run(fmt::format("lens{} --board 7x5 --model opencv_fisheye --serial FE-1 --out {}", files, file.string()));
  ASSERT_EQ(outcome.code, 0) << outcome.err << outcome.out;
  EXPECT_THAT(outcome.out, HasSubstr("6 views are few"));
  EXPECT_GT(std::filesystem::file_size(folder / "calibration.sky-lens.png"), 1000u);

  const auto root = ConfigTable::read_file(file).value();
  const auto sky = root.table("sky");
  EXPECT_EQ(sky.integer("width"), kPictureWidth);
  EXPECT_EQ(sky.text("serial"), "FE-1");
  const auto found = read_lens(sky.table("lens"));
  for (const double off : {0.0, 15.0, 30.0, 45.0}) {
    const double angle = from_degrees(off).value;
    const glm::dvec3 ray{0.6 * std::sin(angle), 0.8 * std::sin(angle), std::cos(angle)};
    EXPECT_LE(glm::distance(found->project(ray).value(), lens->project(ray).value()), 1.0) << off;
  }
  EXPECT_LE(sky.table("measured").table("lens").number("rms_px"), 0.2);
}

TEST(CalibrateLens, AnotherProgramsFileIsImported) {
  const auto folder = fresh_folder("calibrate-import");
  ASSERT_TRUE(write_text_file(folder / "calib_results.txt",
                              "5 -551.7 0.0 8.37e-4 -6.47e-7 1.2e-9\n1 5\n381.75 505.5\n1.0 0.0 0.0\n768 1024\n"));
  const auto file = folder / "c.toml";
  const auto outcome =
      run(fmt::format("lens --import {} --out {}", (folder / "calib_results.txt").string(), file.string()));
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto root = ConfigTable::read_file(file).value();
  EXPECT_EQ(root.table("sky").table("lens").text("model"), "scaramuzza");
  EXPECT_EQ(root.table("sky").integer("height"), 768);
  EXPECT_THAT(root.table("sky").table("measured").table("lens").text("from"), HasSubstr("OCamCalib"));
  EXPECT_THAT(outcome.out, HasSubstr("a direction 60 deg off the axis lands to the right at ("));
  // What has no effect, and what the scene is not drawn through.
  for (const auto& [options, word] : {std::pair{"--board 8x6", "--board: has no effect with --import"},
                                      {"--window", "--window: has no effect with --import"},
                                      {"--model pinhole", "--model pinhole"},
                                      {"--camera scene", "expected a pinhole"}}) {
    const auto refused = run(
        fmt::format("lens --import {} {} --out {}", (folder / "calib_results.txt").string(), options, file.string()));
    EXPECT_EQ(refused.code, 2) << options;
    EXPECT_THAT(refused.err, HasSubstr(word));
  }
}

TEST(CalibrateLens, ReportsAllProblemsAtOnce) {
  const auto outcome = run("lens one.png --board 8by6 --camera scene --model scaramuzza --out /nowhere/c.toml");
  EXPECT_EQ(outcome.code, 2);
  for (const char* part : {"1 pictures", "--board 8by6", "--model scaramuzza"})
    EXPECT_THAT(outcome.err, HasSubstr(part));
  EXPECT_EQ(run("").code, 2);
  EXPECT_EQ(run("sky /nowhere/at-all --out c.toml").code, 2);
}

TEST(CalibrateSky, ARecordedDayRecoversTheCameraItWasRenderedWith) {
  auto recipe = small("clear-noon", 9);
  recipe.sky_size = 300;
  recipe.scene_frames = 1;
  recipe.scene_width = 64;
  recipe.scene_height = 36;
  recipe.start_utc -= std::chrono::hours(2);
  recipe.sky_period_s = 1800.0;
  const auto folder = recorded(recipe, "calibrate-sky");
  const auto truth = read_fixture(folder).value().installation.sky;

  // The recording's own description is falsified: the azimuth by 70 deg, the focal length by 2 %.
  auto text = read_text_file(folder / "fixture.toml").value();
  const auto replace = [&](const std::string& key, double value) {
    const auto at = text.find(key + " = ", text.find("[sky]"));
    ASSERT_NE(at, std::string::npos) << key;
    text.replace(at, text.find('\n', at) - at, fmt::format("{} = {}", key, value));
  };
  const double focal_px = truth.lens->project({1.0, 0.0, 0.0})->x - truth.lens->project({0.0, 0.0, 1.0})->x;
  replace("azimuth_up_deg", 88.0);
  replace("focal_px", 1.02 * focal_px / (0.5 * kPi));
  ASSERT_TRUE(write_text_file(folder / "fixture.toml", text));

  const auto file = fresh_folder("calibrate-sky-out") / "calibration.toml";
  const auto outcome = run(fmt::format("sky {} --out {}", folder.string(), file.string()));
  ASSERT_EQ(outcome.code, 0) << outcome.err << outcome.out;
  const auto root = ConfigTable::read_file(file).value();
  const auto found = read_camera(root.table("sky"), "sky");
  const auto orientation = root.table("sky").table("measured").table("orientation");
  std::printf("%s", outcome.out.c_str());
  const double sigma_deg =
      std::hypot(orientation.number("tilt_east_sigma_deg"), orientation.number("tilt_north_sigma_deg"),
                 orientation.number("azimuth_sigma_deg"));
  const glm::dmat3 by = found.to_world * glm::transpose(truth.to_world);
  const double error_deg = to_degrees({std::acos(std::min(1.0, 0.5 * (by[0][0] + by[1][1] + by[2][2] - 1.0)))});
  EXPECT_LE(error_deg, 4.0 * sigma_deg);
  EXPECT_LE(error_deg, 1.0);
  // Near the sun's path every pixel's viewing direction is right.
  const auto pixel = truth.pixel_of(direction_from(from_degrees(50.0), from_degrees(170.0))).value();
  EXPECT_LE(to_degrees(angle_between(found.direction_at(pixel).value(), truth.direction_at(pixel).value())), 0.25);
  EXPECT_GT(std::filesystem::file_size(file.parent_path() / "calibration.sky-orientation.png"), 1000u);
}

}  // namespace
}  // namespace kasumi
