// kasumi calibrate colour and mask, from a recording to the files that estimate and replay read.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "calib/camera.hpp"
#include "calib/colour/sensitivity_fit.hpp"
#include "fixtures/generator/generator.hpp"
#include "pipeline/site/files/picture_sink.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/install/calibrate/calibrating.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

// A morning seen by a camera whose channels are bell curves at 600, 540 and 450 nm (the generic one), with trees around
// it.
std::filesystem::path morning(const std::filesystem::path& folder) {
  auto recipe = fixtures::recipe_of("papers-noon").value();
  recipe.start_utc = Utc(std::chrono::sys_days(std::chrono::year{2026} / 10 / 19)) + std::chrono::hours(23);
  recipe.sky_frames = 6;
  recipe.sky_period_s = 2400.0;
  recipe.sky_size = 200;
  recipe.sky_format = "RGB3";
  recipe.scene_frames = 1;
  recipe.scene_width = 64;
  recipe.scene_height = 36;
  recipe.truth_frames = 0;
  EXPECT_TRUE(fixtures::generate(recipe, folder / "morning"));
  return folder / "morning";
}

// Other cameras with bell-shaped channels.
std::filesystem::path measured(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder / "cameras");
  int number = 0;
  for (const glm::dvec3 peaks : {glm::dvec3{610, 535, 460}, {592, 530, 470}, {604, 548, 456}, {590, 538, 463}}) {
    SpectralSensitivity camera{"", 380.0, 5.0, {}};
    for (double nm = 380.0; nm <= 780.0; nm += 5.0) {
      const glm::dvec3 off = (nm - peaks) / (36.0 + 3.0 * number);
      camera.samples.push_back(glm::exp(-0.5 * off * off));
    }
    EXPECT_TRUE(write_text_file(folder / "cameras" / fmt::format("camera-{}.csv", number++), csv_of(camera, "")));
  }
  return folder / "cameras";
}

TEST(CalibrateColour, ARecordingGivesAMaskAndThenAUsableSensitivity) {
  const auto folder = fresh_folder("calibrate-colour");
  const auto recording = morning(folder), cameras = measured(folder), file = folder / "calibration.toml";

  const auto mask = run(fmt::format("mask {} --out {}", recording.string(), file.string()));
  ASSERT_EQ(mask.code, 0) << mask.err << mask.out;
  const auto colour = run(fmt::format("colour {} --cameras {} --serial SKY-3 --out {}", recording.string(),
                                      cameras.string(), file.string()));
  ASSERT_EQ(colour.code, 0) << colour.err << colour.out;
  std::printf("%s", colour.out.c_str());
  EXPECT_THAT(colour.out, HasSubstr("camera-3"));
  EXPECT_THAT(colour.out, HasSubstr("Gamma"));

  const auto root = ConfigTable::read_file(file).value();
  const auto sky = root.table("sky");
  EXPECT_EQ(sky.text("mask"), "calibration.sky-free.png");
  EXPECT_EQ(sky.text("colour_space"), "sensor");
  const auto found = read_spectral_sensitivity(sky.file("sensitivity")).value();
  const glm::dvec3 truth{600.0, 540.0, 450.0};
  glm::dvec3 mean{0.0}, area{0.0};
  for (double nm = 380.0; nm <= 780.0; nm += 1.0) {
    mean += nm * found.at(nm);
    area += found.at(nm);
  }
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(mean[c] / area[c], truth[c], 6.0);
  const auto measured_table = sky.table("measured").table("colour");
  EXPECT_GT(measured_table.number("gamma_error_expected"), 0.0);
  EXPECT_LE(measured_table.number("gamma_error_expected"), 0.02);
  EXPECT_LE(measured_table.number("rms_log_ratio"), 0.02);
  EXPECT_GT(measured_table.number("gamma_error_of_sky_10_percent_off"), 0.002);
  EXPECT_GT(std::filesystem::file_size(folder / "calibration.sky-colour.png"), 1000u);
  EXPECT_GT(std::filesystem::file_size(folder / "calibration.sky-mask.png"), 1000u);

  // A second run keeps a mask, which a person may have edited, and the previous curves.
  ended(0, run(fmt::format("mask {} --out {}", recording.string(), file.string())));
  EXPECT_TRUE(std::filesystem::exists(folder / "calibration.sky-free.png.1.old"));
  EXPECT_EQ(ConfigTable::read_file(file).value().table("sky").text("sensitivity"), "calibration.sky-sensitivity.csv");

  // The best-fitting file instead of the estimate.
  const auto chosen = ended(0, run(fmt::format("colour {} --choose --turbidity 2.4 --cameras {} --out {}",
                                               recording.string(), cameras.string(), file.string())));
  EXPECT_THAT(chosen.out, HasSubstr("chosen: camera-"));
  EXPECT_TRUE(std::filesystem::exists(folder / "calibration.sky-sensitivity.csv.1.old"));

  // A scene camera of the same make.
  ended(0, run(fmt::format("colour {} --camera scene --choose --cameras {} --out {}", recording.string(),
                           cameras.string(), file.string())));
  const auto of_scene = ConfigTable::read_file(file).value().table("scene");
  EXPECT_EQ(of_scene.text("sensitivity"), "calibration.scene-sensitivity.csv");
  EXPECT_FALSE(of_scene.has("white_balance"));
}

TEST(CalibrateColour, ReportsAllProblemsAtOnceAndWritesNothing) {
  const auto folder = fresh_folder("calibrate-colour-wrong");
  ASSERT_TRUE(write_text_file(folder / "grey.csv", "wavelength,r,g,b\n400,1,1,1\n500,2,2,2\n600,1,1,1\n"));
  const auto outcome =
      run(fmt::format("colour /nowhere/at-all --cameras {} {} {} --out {}", (folder / "grey.csv").string(),
                      (folder / "none.json").string(), folder.string(), (folder / "c.toml").string()));
  EXPECT_EQ(outcome.code, 2);
  for (const char* part : {"at-all", "grey.csv: expected three different channels", "none.json"})
    EXPECT_THAT(outcome.err, HasSubstr(part));
  EXPECT_FALSE(std::filesystem::exists(folder / "c.toml"));
  EXPECT_FALSE(std::filesystem::exists(folder / "c.sky-sensitivity.csv"));
}

TEST(CalibrateMask, StrokesOnASceneBecomeAMaskNextToTheCalibration) {
  const auto folder = fresh_folder("calibrate-mask");
  // Dark green below a jagged edge, pale blue above.
  Image<Rgb8> picture(160, 90, Rgb8(170, 185, 205));
  const auto edge = [](int x) { return 60 - std::abs(x % 40 - 20); };
  for (int y = 0; y < 90; ++y)
    for (int x = 0; x < 160; ++x) {
      const int grain = (x * 7 + y * 13) % 5;
      picture.at(x, y) =
          y >= edge(x) ? Rgb8(40 + 3 * grain, 62 + 4 * grain, 30 + 2 * grain) : Rgb8(170 + grain, 185 + grain, 205);
    }
  ASSERT_TRUE(write_png(folder / "scene.png", picture));
  ASSERT_TRUE(write_text_file(folder / "strokes.toml",
                              "[[hidden]]\npoints = [5, 80, 150, 82]\n[[free]]\npoints = [5, 10, 150, 14]\n"));
  const auto file = folder / "calibration.toml";
  ended(0, run(fmt::format("mask --picture {} --strokes {} --out {}", (folder / "scene.png").string(),
                           (folder / "strokes.toml").string(), file.string())));
  const auto scene = ConfigTable::read_file(file).value().table("scene");
  EXPECT_EQ(scene.text("mask"), "calibration.scene-free.png");
  const cv::Mat mask = cv::imread((folder / "calibration.scene-free.png").string(), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(mask.type(), CV_8UC1);
  int wrong = 0;
  for (int y = 0; y < 90; ++y)
    for (int x = 0; x < 160; ++x)
      if (std::abs(y - edge(x)) > 2 && (mask.at<std::uint8_t>(y, x) < 128) != (y >= edge(x))) ++wrong;
  EXPECT_LE(wrong, 20);
  EXPECT_GT(std::filesystem::file_size(folder / "calibration.scene-mask.png"), 1000u);

  EXPECT_THAT(ended(2, run(fmt::format("mask --out {}", file.string()))).err, HasSubstr("--picture and --strokes"));
  EXPECT_THAT(ended(2, run(fmt::format("mask --picture {} --strokes {} --box 100,50,100,50 --out {}",
                                       (folder / "scene.png").string(), (folder / "none.png").string(), file.string())))
                  .err,
              testing::AllOf(HasSubstr("none.png"), HasSubstr("--box 100,50,100,50")));
}

}  // namespace
}  // namespace kasumi
