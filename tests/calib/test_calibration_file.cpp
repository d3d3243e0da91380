#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "base/files.hpp"
#include "calib/calibration_file.hpp"
#include "tests/must.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;
using testing::Not;

std::filesystem::path fresh_folder(const std::string& name) {
  const auto folder = test_output_folder() / "calibration" / name;
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder;
}

CalibrationStep lens_step() {
  CalibrationStep step;
  step.camera = "sky";
  step.width = 1032;
  step.height = 778;
  step.serial = "FE \"185\"";
  step.lens = LensDescription{OpencvFisheyeParameters{{336.8, 337.9}, {543.4, 377.7}, {-0.013, 0.021, -0.0074, 0.0011}},
                              from_degrees(95.0)};
  step.calibrated_utc = "2026-11-21T10:00:00Z";
  step.measured.push_back({"lens", "2026-11-21T10:00:00Z", "2 pictures: a\\b.jpg", {{"rms_px", 0.4}}, {"c.jpg: bad"}});
  return step;
}

CalibrationStep orientation_step() {
  CalibrationStep step;
  step.camera = "sky";
  step.width = 1032;
  step.height = 778;
  step.to_world = camera_to_world(from_degrees(200.0), from_degrees(88.0), from_degrees(3.0));
  step.response = "srgb";
  step.site = Site{"", 46.9, 8.25, 450.0};
  step.calibrated_utc = "2026-11-22T12:00:00Z";
  step.measured.push_back({"orientation", "2026-11-22T12:00:00Z", "100 suns", {{"heading_sigma_deg", 0.02}}, {}});
  return step;
}

TEST(CalibrationFile, EachStepKeepsTheOthersResults) {
  const auto file = fresh_folder("steps") / "calibration.toml";
  const auto first = must(write_calibration(file, lens_step()));
  EXPECT_FALSE(first->backup);
  const auto before = read_text_file(file).value();
  const auto second = must(write_calibration(file, orientation_step()));
  ASSERT_TRUE(second->backup);
  EXPECT_EQ(read_text_file(*second->backup).value(), before);

  const auto root = must(ConfigTable::read_file(file));
  EXPECT_EQ(root->integer("calibration"), 1);
  const auto site = read_site(root->table("site"));
  const auto camera = read_camera(root->table("sky"), "sky");
  const auto whole = root->finish();
  ASSERT_TRUE(whole) << whole.error().message;
  EXPECT_EQ(site.latitude_deg, 46.9);
  EXPECT_EQ(camera.width, 1032);
  EXPECT_EQ(root->table("sky").text("serial"), "FE \"185\"");
  EXPECT_EQ(camera.lens->name(), "opencv_fisheye");
  const auto truth = make_lens(*lens_step().lens);
  const glm::dvec3 ray{0.5, -0.3, 0.8};
  EXPECT_LE(glm::distance(*camera.lens->project(ray), *truth->project(ray)), 1e-9);
  for (int axis = 0; axis < 3; ++axis)
    EXPECT_LE(glm::distance(camera.to_world[axis], (*orientation_step().to_world)[axis]), 1e-9);
  EXPECT_THAT(read_text_file(file).value(), HasSubstr("rms_px = 0.4"));
}

TEST(CalibrationFile, ARepeatedStepReplacesItsOwnValuesAndKeepsEveryOldFile) {
  const auto file = fresh_folder("again") / "calibration.toml";
  auto step = lens_step();
  ASSERT_TRUE(write_calibration(file, step));
  step.measured[0].numbers = {{"rms_px", 0.77}};
  const auto second = write_calibration(file, step);
  const auto third = write_calibration(file, step);
  ASSERT_TRUE(second) << second.error().message;
  ASSERT_TRUE(third) << third.error().message;
  EXPECT_NE(*second->backup, *third->backup);
  const auto text = read_text_file(file).value();
  EXPECT_THAT(text, HasSubstr("0.77"));
  EXPECT_THAT(text, Not(HasSubstr("rms_px = 0.4")));
}

TEST(CalibrationFile, AFileOfAnotherKindOrSizeIsLeftAlone) {
  const auto folder = fresh_folder("other");
  ASSERT_TRUE(write_text_file(folder / "kasumi.toml", "[sky]\nwidth = 3\n"));
  const auto other = write_calibration(folder / "kasumi.toml", lens_step());
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().kind, FaultKind::bad_input);
  EXPECT_EQ(read_text_file(folder / "kasumi.toml").value(), "[sky]\nwidth = 3\n");

  ASSERT_TRUE(write_calibration(folder / "c.toml", lens_step()));
  auto small = lens_step();
  small.width = 516;
  EXPECT_THAT(write_calibration(folder / "c.toml", small), FailsWith(HasSubstr("1032 x 778")));
}

TEST(CalibrationFile, AnglesRoundTripForEveryOrientation) {
  for (const double heading : {-170.0, 0.0, 35.0})
    for (const double pitch : {-40.0, 0.0, 60.0, 89.9})
      for (const double roll : {-120.0, 0.0, 7.0}) {
        const auto truth = camera_to_world(from_degrees(heading), from_degrees(pitch), from_degrees(roll));
        const auto angles = heading_pitch_roll(truth);
        EXPECT_NEAR(to_degrees(angles.heading), heading, 1e-6);
        EXPECT_NEAR(to_degrees(angles.pitch), pitch, 1e-6);
        EXPECT_NEAR(to_degrees(angles.roll), roll, 1e-6);
      }
  const auto up = camera_to_world(from_degrees(25.0), from_degrees(90.0), from_degrees(0.0));
  const auto angles = heading_pitch_roll(up);
  const auto again = camera_to_world(angles.heading, angles.pitch, angles.roll);
  for (int axis = 0; axis < 3; ++axis) EXPECT_LE(glm::distance(again[axis], up[axis]), 1e-9);
}

TEST(LensDescription, IsReadBackAsWrittenAndResizingScalesEveryRadius) {
  for (const auto& description :
       {LensDescription{IdealFisheyeParameters{{10.5, 20.0}, 150.0, true}, from_degrees(95.0)},
        LensDescription{OpencvFisheyeParameters{{330.0, 331.5}, {540, 370.25}, {0.01, 0, 0, 0}}, from_degrees(90.0)},
        LensDescription{
            ScaramuzzaParameters{{-551.7655, 0.0, 8.4e-4, -6.5e-7, 1.2e-9}, {505.5, 381.75}, 1.003, 1e-3, 0.0},
            from_degrees(100.0)},
        LensDescription{PinholeParameters{{800, 801.5}, {320, 240}, {-0.1, 0.01, 1e-3, 0, 0}}}}) {
    const auto root = must(ConfigTable::parse("[lens]\n" + toml_of(description), "lens.toml"));
    const auto again = read_lens_description(root->table("lens"));
    ASSERT_TRUE(root->finish()) << model_name(description);
    EXPECT_EQ(toml_of(again), toml_of(description));
    const glm::dvec3 ray{0.3, 0.2, 0.9};
    const auto before = make_lens(description)->project(ray).value() - centre_of(description);
    const auto after = make_lens(moved(description, {7.0, 9.0}, 1.25))->project(ray).value() - glm::dvec2{7.0, 9.0};
    EXPECT_LE(glm::distance(after, 1.25 * before), 1e-9) << model_name(description);
  }
}

}  // namespace
}  // namespace kasumi
