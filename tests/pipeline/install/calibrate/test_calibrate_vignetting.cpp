// kasumi calibrate vignetting, from a recorded day to the file.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/calibration_file.hpp"
#include "pipeline/site/config/fixture_file.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/install/calibrate/calibrating.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

TEST(CalibrateVignetting, ARecordedDayRecoversTheLensItWasRenderedThrough) {
  auto recipe = small("papers-noon", 7);
  recipe.turbidity = recipe.turbidity_end = 4.5;
  recipe.sky_size = 240;
  recipe.scene_frames = 1;
  recipe.scene_width = 64;
  recipe.scene_height = 36;
  recipe.start_utc -= std::chrono::hours(3);
  recipe.sky_period_s = 3600.0;
  const auto folder = recorded(recipe, "calibrate-vignetting");
  const auto truth = read_fixture(folder).value().installation.sky;
  const auto file = fresh_folder("calibrate-vignetting-out") / "calibration.toml";

  // Nothing is known about the camera yet: this is reported, and nothing is written.
  EXPECT_THAT(ended(2, run(fmt::format("vignetting {} --out {}", folder.string(), file.string()))).err,
              HasSubstr("expected the calibration file with the sky camera's lens and orientation"));
  EXPECT_FALSE(std::filesystem::exists(file));

  CalibrationStep step;
  step.camera = "sky";
  step.width = truth.width;
  step.height = truth.height;
  step.lens = read_lens_description(ConfigTable::read_file(folder / "fixture.toml").value().table("sky").table("lens"));
  step.to_world = truth.to_world;
  step.response = "srgb";
  step.calibrated_utc = "2026-06-21T00:00:00Z";
  ASSERT_TRUE(write_calibration(file, step));
  const auto outcome = run(fmt::format("vignetting {} --out {}", folder.string(), file.string()));
  ASSERT_EQ(outcome.code, 0) << outcome.err << outcome.out;
  std::printf("%s", outcome.out.c_str());
  const auto root = ConfigTable::read_file(file).value();
  const auto found = read_camera(root.table("sky"), "sky");
  for (const double part : {0.2, 0.4, 0.6, 0.8, 0.88}) {
    const glm::dvec2 pixel = truth.vignetting.centre + glm::dvec2{0.5 * 240 * part, 0.0};
    EXPECT_NEAR(found.vignetting.at(pixel) / truth.vignetting.at(pixel), 1.0, 0.01) << part;
  }
  const auto measured = root.table("sky").table("measured").table("vignetting");
  EXPECT_LE(measured.number("rim_sigma"), 0.05);
  EXPECT_EQ(measured.text("picture"), "calibration.sky-vignetting.png");
  EXPECT_GT(std::filesystem::file_size(file.parent_path() / "calibration.sky-vignetting.png"), 1000u);
}

}  // namespace
}  // namespace kasumi
