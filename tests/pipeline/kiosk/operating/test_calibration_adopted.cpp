// One calibration file, referred to by the kiosk's configuration and by recordings, instead of copied tables.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>

#include <sys/wait.h>

#include "base/utc_text.hpp"
#include "calib/calibration_file.hpp"
#include "pipeline/lab/recording/recording.hpp"
#include "pipeline/site/config/content.hpp"
#include "pipeline/site/config/fixture_file.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/kiosk/operating/kiosk.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

std::string without(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from), end = text.find(to, at);
  EXPECT_NE(at, std::string::npos) << from;
  EXPECT_NE(end, std::string::npos) << to;
  return text.erase(at, end - at);
}

// Results of the installer's calibration steps: lens and orientation of the sky camera; pose, response, noise of the
// scene camera.
void write_measured(const std::filesystem::path& file, int sky_width = kKioskWidth) {
  CalibrationStep sky;
  sky.camera = "sky";
  sky.width = sky_width;
  sky.height = kKioskHeight;
  sky.serial = "SKY-1";
  sky.lens = LensDescription{IdealFisheyeParameters{{30.25, 22.75}, 15.5, false}, from_degrees(85.0)};
  sky.to_world = camera_to_world(from_degrees(200.0), from_degrees(88.0), from_degrees(3.0));
  sky.response = "linear";
  sky.site = Site{"", 46.9, 8.25, 450.0};
  sky.calibrated_utc = "2026-11-21T10:00:00Z";
  sky.measured.push_back({"lens", "2026-11-21T10:00:00Z", "nothing", {{"rms_px", 0.4}}, {"a remark"}});
  ASSERT_TRUE(write_calibration(file, sky));
  CalibrationStep scene;
  scene.camera = "scene";
  scene.width = kKioskWidth;
  scene.height = kKioskHeight;
  scene.to_world = camera_to_world(from_degrees(4.5), from_degrees(0.75), from_degrees(0.25));
  scene.curve = MeasuredCurve{{std::vector{0.0, 0.3, 1.0}, {0.0, 0.3, 1.0}, {0.0, 0.3, 1.0}}};
  scene.vignetting = Vignetting{{31.0, 24.0}, 40.0, {-0.1, 0.02, 0.0}};
  scene.noise = {11000.0, 4.5};
  scene.calibrated_utc = "2026-11-22T10:00:00Z";
  ASSERT_TRUE(write_calibration(file, scene));
}

// The kiosk's configuration without the sky camera's lens, orientation and response.
std::filesystem::path write_calibrated_kiosk(const std::filesystem::path& folder) {
  const auto config = write_kiosk(folder);
  auto text = read_text_file(config).value();
  text = without(text, "latitude_deg", "[sky]");
  text = without(text, "azimuth_up_deg", "mask = ");
  text = without(text, "[sky.lens]", "[sky.camera]");
  text = without(text, "response", "[scene.lens]");  // the scene camera's
  text = "calibration = \"measured/calibration.toml\"\n" + text;
  EXPECT_TRUE(write_text_file(config, text));
  std::filesystem::create_directories(folder / "measured");
  return config;
}

struct CheckOutcome {
  int code = -1;
  std::string output;
};
CheckOutcome check(const std::filesystem::path& config) {
  CheckOutcome outcome;
  const auto command = fmt::format("{} run --config '{}' --check 2>&1", kasumi_program().string(), config.string());
  FILE* pipe = ::popen(command.c_str(), "r");
  if (!pipe) return outcome;
  std::array<char, 4096> buffer;
  for (std::size_t n; (n = std::fread(buffer.data(), 1, buffer.size(), pipe)) > 0;)
    outcome.output.append(buffer.data(), n);
  outcome.code = WEXITSTATUS(::pclose(pipe));
  return outcome;
}

TEST(CalibrationAdopted, TheKioskUsesMeasuredValuesThatItDoesNotOverride) {
  const auto folder = operating_folder("adopted");
  const auto config = write_calibrated_kiosk(folder);
  write_measured(folder / "measured/calibration.toml");
  const auto content = must(read_content(config));
  const auto& installation = (*content)->config.installation;
  EXPECT_EQ(installation.site.latitude_deg, 46.9);
  EXPECT_EQ(installation.sky.response.kind(), Response::Kind::linear);
  EXPECT_NEAR(installation.sky.lens->project({0.0, 0.0, 1.0})->x, 30.25, 1e-12);
  EXPECT_FALSE(installation.sky.mask.empty()) << "the configuration's own value is kept";
  EXPECT_NEAR(installation.scene.response.to_light(glm::dvec3(0.5)).y, 0.3, 1e-12);
  EXPECT_NEAR(installation.scene.vignetting.at({71.0, 24.0}), 0.92, 1e-12);
  EXPECT_EQ(installation.scene_quality.full_scale_electrons, 11000.0);
  EXPECT_EQ(installation.scene_quality.read_electrons, 4.5);
  ASSERT_TRUE(installation.calibration);
  EXPECT_THAT(installation.calibration->gained, Contains("sky.lens"));
  // kasumi.toml gives heading 4 and pitch 0.5: the roll is its default 0, not the calibration's.
  EXPECT_THAT(installation.calibration->overruled, Contains("scene.roll_deg"));
  const auto straight = camera_to_world(from_degrees(4.0), from_degrees(0.5), from_degrees(0.0));
  for (int axis = 0; axis < 3; ++axis) EXPECT_EQ(installation.scene.to_world[axis], straight[axis]);
  EXPECT_THAT(utc_text(*installation.scene.calibrated_utc), HasSubstr("2026-11-22"));

  const auto outcome = check(config);
  EXPECT_EQ(outcome.code, 0) << outcome.output;
  for (const char* part : {"calibration.toml: the sky camera's of 2026-11-21", "scene camera's of 2026-11-22",
                           "from it: site.altitude_m", "overridden by kasumi.toml: ", "scene.roll_deg"})
    EXPECT_THAT(outcome.output, HasSubstr(part));
}

TEST(CalibrationAdopted, ARecordingContainsAllAdoptedValues) {
  const auto folder = operating_folder("adopted-recorded");
  const auto config = write_calibrated_kiosk(folder);
  write_measured(folder / "measured/calibration.toml");
  // One mask next to the calibration file, one next to the configuration.
  std::filesystem::copy_file(folder / "roof mask.pgm", folder / "measured/trees.pgm");
  auto text = read_text_file(folder / "measured/calibration.toml").value();
  text.insert(text.find("[scene]\n") + 8, "mask = \"trees.pgm\"\n");
  ASSERT_TRUE(write_text_file(folder / "measured/calibration.toml", text));
  const auto recording = Recording::create(config, folder / "kept", Utc{}, {});
  ASSERT_TRUE(recording) << recording.error().message;
  const auto kept = must(read_fixture(folder / "kept"));
  EXPECT_FALSE(kept->installation.calibration) << "it is self-contained";
  EXPECT_EQ(kept->installation.site.longitude_deg, 8.25);
  EXPECT_EQ(kept->installation.sky.lens->project({0.0, 0.0, 1.0}), glm::dvec2(30.25, 22.75));
  EXPECT_EQ(kept->installation.scene_quality.read_electrons, 4.5);
  EXPECT_FALSE(kept->installation.scene.mask.empty());
}

TEST(CalibrationAdopted, AFixtureMayUseOneToo) {
  const auto folder = operating_folder("adopted-fixture");
  write_measured(folder / "calibration.toml");
  std::filesystem::copy_file(source_folder() / "fixtures/temple.glb", folder / "temple.glb");
  ASSERT_TRUE(write_text_file(folder / "fixture.toml", R"(format = 1
name = "x"
licence = "CC0-1.0"
provenance = "by hand"
start_utc = 2026-06-21T03:00:00Z
calibration = "calibration.toml"
[scene.lens]
model = "pinhole"
focal_px = [600.0, 600.0]
centre_px = [31.5, 23.5]
[object]
model = "temple.glb"
east_m = 306.0
north_m = 3487.15
up_m = -39.0
)"));
  const auto fixture = must(read_fixture(folder));
  EXPECT_EQ(fixture->installation.scene.width, kKioskWidth);
  EXPECT_EQ(fixture->installation.site.altitude_m, 450.0);
}

TEST(CalibrationAdopted, AnInvalidFileGivesOneMessage) {
  const auto folder = operating_folder("adopted-wrong");
  const auto config = write_calibrated_kiosk(folder);
  const auto file = folder / "measured/calibration.toml";
  const auto refused_with = [&](const std::string& part) {
    const auto outcome = check(config);
    EXPECT_EQ(outcome.code, 78) << part;
    EXPECT_THAT(outcome.output, HasSubstr("kasumi.toml: calibration = "));
    EXPECT_THAT(outcome.output, HasSubstr(part));
    EXPECT_THAT(outcome.output, Not(HasSubstr("is missing: expected a")))
        << "what it would have supplied is not listed";
    EXPECT_THAT(outcome.output, Not(HasSubstr("altitude_m")));
  };
  refused_with("an existing file");
  ASSERT_TRUE(write_text_file(file, "[sky]\nwidth = 3\n"));
  refused_with("a file that kasumi calibrate wrote");
  ASSERT_TRUE(write_text_file(file, "calibration = 7\n"));
  refused_with("calibration: expected 1");
  ASSERT_TRUE(write_text_file(file, "calibration = 1\n[skye]\nwidth = 3\n"));
  refused_with("skye: unknown key");
  ASSERT_TRUE(write_text_file(file, "calibration = = 1\n"));
  refused_with("not valid TOML");
  std::filesystem::remove(file);
  write_measured(file, 640);
  refused_with("a calibration of 64 x 48 pictures, the size [sky] gives (that one was done on 640 x 48)");
}

TEST(CalibrationAdopted, AWrongValueIsReportedWithItsFile) {
  const auto folder = operating_folder("adopted-value");
  const auto config = write_calibrated_kiosk(folder);
  const auto file = folder / "measured/calibration.toml";
  write_measured(file);
  auto text = read_text_file(file).value();
  const auto at = text.find("focal_px = ");
  text.insert(at + 11, "-");
  ASSERT_TRUE(write_text_file(file, text));
  const auto outcome = check(config);
  EXPECT_EQ(outcome.code, 78);
  EXPECT_THAT(outcome.output, HasSubstr("measured/calibration.toml: sky.lens.focal_px = -15.5"));
}

}  // namespace
}  // namespace kasumi
