// The daily check of the calibration under a manual clock: it reports in the status and changes nothing else.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "base/outside/json_text.hpp"
#include "capture/fixture/fixture.hpp"
#include "capture/fixture/replay_source.hpp"
#include "pipeline/install/camera_drift/drift_reference.hpp"
#include "pipeline/site/files/photograph_file.hpp"
#include "pipeline/site/files/picture_sink.hpp"
#include "tests/pipeline/kiosk/appliance/rig.hpp"
#include "tests/pipeline/recorded.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

// The bench's recording begins at 3:00 UTC: a check at 3:00 for 6 s of every day.
RigOptions checked(const std::string& name, const std::string& time = "03:00") {
  RigOptions options;
  options.name = name;
  options.observe_every = 1s;  // its time leaps past a night
  options.more_config = fmt::format("\n[opening]\ntime_zone = \"UTC\"\n[check]\ntime = \"{}\"\nminutes = 0.1\n", time);
  return options;
}

nlohmann::json check_status(Rig& rig) {
  rig.status();
  return parse_json(read_text_file(rig.folder / "status.json").value())["check"];
}

// The reference: the bench's scene camera before it was tilted down by half a degree.
DriftReference before_the_bump(const Installation& installation) {
  auto recipe = small("clear-noon", 1);
  recipe.start_utc = std::chrono::sys_days{std::chrono::June / 21 / 2026} + 3h;
  recipe.sky_frames = 1;
  recipe.sky_size = 120;
  recipe.scene_width = 320;
  recipe.scene_height = 180;
  recipe.outlook.pitch_deg += 0.5;
  const auto folder = recorded(recipe, "bench-before-the-bump");
  const auto row = read_index(folder / "scene").value().front();
  const Frame frame{row.metadata, payload_of(read_file(folder / "scene" / row.payload).value())};
  const auto picture = decode(frame, YuvEncoding::bt601_full).value();
  DriftFrames frames(installation);
  for (int i = 0; i < kFewestCheckFrames; ++i) frames.add_scene(picture.view());
  return take_reference(frames, installation, recipe.start_utc).value();
}

// In steps of its picture interval: 15 pictures.
bool check_again(Rig& rig, std::optional<Utc> last = {}, int ticks = 150) {
  for (int i = 0; i < ticks; ++i) {
    rig.advance(400ms, 400ms);
    if (const auto& check = rig.status().check; check && check->at != last) return true;
  }
  return false;
}

TEST(DailyCheck, TheFirstTakesTheReferenceAndTheNextFindsNoDrift) {
  Rig rig(checked("check-well"));
  EXPECT_TRUE(check_status(rig).is_null());
  ASSERT_TRUE(check_again(rig));
  EXPECT_THAT(check_status(rig)["summary"].get<std::string>(), HasSubstr("reference from now on"));
  EXPECT_TRUE(std::filesystem::exists(rig.folder / "state/calibration.check.json"));
  EXPECT_EQ(rig.shown(), Shown::live) << "the picture goes on";
  const auto at = rig.status().check->at;
  EXPECT_FALSE(check_again(rig, at, 30)) << "once a day";
  rig.advance(24h - (rig.clock.utc() - at), 2h);
  ASSERT_TRUE(check_again(rig, at));
  const auto check = check_status(rig);
  EXPECT_EQ(check["well"], true) << check.dump(1);
  EXPECT_FALSE(check["findings"].empty());
}

// `recording` says no, and whoever opens a file of the state's folder sees nobody.
TEST(DailyCheck, NoPictureIsLeftByADayWithTheCheck) {
  Rig rig(checked("check-keeps-nothing"));
  // As an earlier version left it.
  const auto pictures = {"state/calibration.check-scene.png", "state/calibration.check-sky.png",
                         "state/calibration.check-dome.png"};
  for (const auto* picture : pictures)
    ASSERT_TRUE(write_png(rig.folder / picture, Image<Rgb8>(8, 8, Rgb8{10, 20, 30})));
  rig.advance(1s);
  for (const auto* picture : pictures) EXPECT_FALSE(std::filesystem::exists(rig.folder / picture)) << picture;
  ASSERT_TRUE(check_again(rig)) << "the reference";
  const auto at = rig.status().check->at;
  rig.advance(24h - (rig.clock.utc() - at), 2h);
  ASSERT_TRUE(check_again(rig, at)) << "compared with, a day later";
  ASSERT_TRUE(rig.status().check->report);
  std::set<std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(rig.folder / "state")) {
    files.insert(entry.path().filename().string());
    EXPECT_FALSE(read_photograph(entry.path())) << entry.path() << " is a picture";
  }
  EXPECT_THAT(files, testing::IsSupersetOf({"calibration.check.json"}));
  files.erase("history.txt");  // numbers and words, a line a minute
  files.erase("layer.bin");    // the building alone: the same after other pictures (LayersOfBefore)
  EXPECT_THAT(files, testing::Each(testing::EndsWith(".json")));
  EXPECT_EQ(parse_json(read_text_file(rig.folder / "status.json").value())["recording"], false);
}

TEST(DailyCheck, ABumpedCameraIsReportedWithItsTurnAndThePictureGoesOn) {
  Rig rig(checked("check-bumped"));
  const auto installation = read_content(rig.config).value()->config.installation;
  ASSERT_TRUE(save_reference(before_the_bump(installation), rig.folder / "state/calibration"));
  ASSERT_TRUE(check_again(rig));
  const auto check = check_status(rig);
  EXPECT_EQ(check["well"], false) << check.dump(1);
  EXPECT_THAT(check["summary"].get<std::string>(), HasSubstr("scene camera, view: the camera has turned by 0."));
  for (const auto& finding : check["findings"])
    if (finding["camera"] == "scene" && finding["what"] == "view") {
      EXPECT_NEAR(finding["value"].get<double>(), 0.5, 0.02);
      EXPECT_EQ(finding["unit"], "deg");
    }
  EXPECT_EQ(rig.shown(), Shown::live);
}

TEST(DailyCheck, ItIsSkippedWithoutATrustedTimeOrWhenDisabled) {
  Rig never(checked("check-never", "never"));
  never.advance(20s, 1s);
  EXPECT_TRUE(check_status(never).is_null());
  auto options = checked("check-unknown");
  options.clock_policy = "synchronized";
  Rig unknown(options);
  unknown.advance(20s, 1s);
  EXPECT_TRUE(check_status(unknown).is_null());
}

}  // namespace
}  // namespace kasumi
