// What may go wrong with display, disk, service and content (design: faults, by row).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <fstream>
#include <random>
#include <set>
#include <thread>

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "pipeline/appliance/remembered_state.hpp"
#include "tests/pipeline/appliance/rig.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

TEST(Appliance, Row15WithoutADisplayAtBootItWaitsAndIsNotReady) {
  Rig rig({.name = "row15-boot", .display = {.unplugged = true}});
  rig.advance(30s);
  EXPECT_EQ(rig.notifier.readies, 0);
  EXPECT_GT(rig.notifier.extensions, 1) << "the service manager is asked for more time";
  EXPECT_GE(rig.notifier.alives, 25) << "a television that is switched off is no reason to restart";
  EXPECT_FALSE(rig.status().render.display.up);
  rig.devices.display.unplugged = false;
  EXPECT_TRUE(rig.recover("15 no display at boot, then one", 3s));
  EXPECT_EQ(rig.notifier.readies, 1);
}

TEST(Appliance, Row15ADisplayThatComesBackWithAnotherModeShowsThePicture) {
  const auto rig = running({.name = "row15"});
  rig->devices.display.unplugged = true;
  rig->advance(20s);
  EXPECT_FALSE(rig->status().render.display.up);
  const auto alives = rig->notifier.alives;
  rig->advance(20s);
  EXPECT_GE(rig->notifier.alives, alives + 15);
  rig->devices.display.unplugged = false;
  rig->devices.display.other_size = {640, 400};
  const auto took = rig->advance_until([&] { return rig->shown() == Shown::live && !rig->picture().empty(); }, 3s);
  ASSERT_TRUE(took);
  std::printf("%-52s live after %.2f s\n", "15 display back with another mode", to_seconds(*took));
  EXPECT_EQ(rig->picture().width(), 640);
}

// Right after a failed attempt, when the wait for the next is longest.
TEST(Appliance, Row15APluggedInDisplayIsDetectedAtOnce) {
  const auto rig = running({.name = "row15-told"});
  auto& display = rig->devices.display;
  display.unplugged = true;
  rig->advance(5s);
  const auto tried = display.tried, opened = display.opened;
  ASSERT_TRUE(rig->advance_until([&] { return display.tried > tried; }, 1100ms));
  display.unplugged = false;
  display.told = true;
  const auto took = rig->advance_until([&] { return display.opened > opened; }, 1100ms);
  ASSERT_TRUE(took);
  std::printf("%-52s opened after %.2f s\n", "15 display plugged in", to_seconds(*took));
  EXPECT_LE(*took, 260ms);
}

TEST(Appliance, Row15ALooseConnectorCausesFewAttempts) {
  const auto rig = running({.name = "row15-storm"});
  auto& display = rig->devices.display;
  display.unplugged = true;
  rig->advance(100ms);
  const auto tried = display.tried;
  for (int i = 0; i < 500; ++i) {
    display.told = true;
    rig->advance(Rig::kTick);
  }
  EXPECT_LE(display.tried - tried, 41) << "four times a second for ten seconds";
  display.unplugged = display.told = false;
  EXPECT_TRUE(rig->recover("15 plugged in after a storm of status", 2s));
}

TEST(Appliance, Row16AFlipThatNeverCompletesLeadsToANewModeset) {
  const auto rig = running({.name = "row16"});
  rig->devices.display.stuck = rig->devices.display.opening_mends = true;
  const auto opened = rig->devices.display.opened;
  const auto took = rig->advance_until(
      [&] { return rig->devices.display.opened > opened && rig->shown() == Shown::live && rig->age_on_screen(); }, 3s);
  ASSERT_TRUE(took);
  std::printf("%-52s live after %.2f s\n", "16 flip never completes", to_seconds(*took));
  EXPECT_LE(*took, 2200ms);
  rig->advance(500ms);
  EXPECT_GT(rig->status().render.display.flip_timeouts, 0u);
  EXPECT_EQ(rig->status().render.display.resets, 1u);
}

TEST(Appliance, Row16ALostMasterIsRequestedAgainAndTheWatchdogNotFed) {
  const auto rig = running({.name = "row16-master"});
  rig->devices.display.busy = true;
  rig->advance(2s);
  const auto alives = rig->notifier.alives;
  rig->advance(30s);
  EXPECT_EQ(rig->notifier.alives, alives) << "a new modeset, else a restart";
  rig->devices.display.busy = false;
  EXPECT_TRUE(rig->recover("16 DRM master taken, given back", 3s));
}

TEST(Appliance, Row17ALostContextIsRebuilt) {
  const auto rig = running({.name = "row17"});
  const auto before = rig->picture();
  rig->devices.display.context_lost = true;
  rig->advance(40ms);
  const auto took = rig->recover("17 GL context lost", 2s);
  ASSERT_TRUE(took);
  EXPECT_LE(*took, 2s);
  EXPECT_EQ(rig->status().render.display.resets, 1u);
  // The same building again: only the frame's number differs.
  const auto after = rig->picture();
  ASSERT_EQ(after.width(), before.width());
  int different = 0;
  for (int y = 20; y < before.height(); ++y)
    for (int x = 0; x < before.width(); ++x)
      if (std::abs(before.at(x, y).g - after.at(x, y).g) > 2) ++different;
  EXPECT_LT(different, before.width() * before.height() / 500);
}

// A driver may take minutes to compile the scene's shaders.
TEST(Appliance, Row17TheStillIsDisplayedBeforeTheSceneIsDrawn) {
  const auto rig = running({.name = "row17-still"});
  const auto& status = rig->appliance->render().status();
  rig->devices.display.context_lost = true;
  const auto lost = rig->advance_until([&] { return status.display.resets == 1; }, 1s);
  ASSERT_TRUE(lost) << "noticed with the next frame, which waits to be drawn";
  const auto pictures = status.pictures, scene_frames = status.scene_frames, uploads = status.uploads;
  ASSERT_TRUE(rig->advance_until([&] { return status.pictures > pictures; }, 1s));
  EXPECT_EQ(status.scene_frames, scene_frames);
  EXPECT_EQ(status.uploads, uploads);
  EXPECT_TRUE(rig->shows_still());
  rig->advance(Rig::kTick);
  EXPECT_EQ(status.scene_frames, scene_frames + 1) << "the frame that waited follows at once";
}

TEST(Appliance, Row18AHangingLoopDoesNotFeedTheWatchdog) {
  const auto rig = running({.name = "row18"});
  rig->advance(10s);
  const auto alives = rig->notifier.alives;
  EXPECT_GE(alives, 12) << "about once a second while it runs";
  rig->render_hangs = true;
  rig->advance(30s);
  EXPECT_EQ(rig->notifier.alives, alives);
}

TEST(Appliance, Row18ALostCameraDoesNotStarveTheWatchdog) {
  const auto rig = running({.name = "row18-camera"});
  rig->devices.scene.unplugged = rig->devices.sky.unplugged = true;
  rig->advance(10s);
  const auto alives = rig->notifier.alives;
  rig->advance(60s);
  EXPECT_GE(rig->notifier.alives, alives + 50) << "a still picture counts as a picture";
}

TEST(Appliance, Row18AStuckDisplayDoesNotFeedTheWatchdog) {
  const auto rig = running({.name = "row18-stuck"});
  rig->devices.display.stuck = true;
  rig->advance(1s);
  const auto alives = rig->notifier.alives;
  rig->advance(20s);
  EXPECT_EQ(rig->notifier.alives, alives);
}

// Simulates a full disk by a limit on the size of files.
class FullDisk {
 public:
  FullDisk() {
    handler_ = std::signal(SIGXFSZ, SIG_IGN);
    ::getrlimit(RLIMIT_FSIZE, &before_);
    rlimit none{0, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &none);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;
  ~FullDisk() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  rlimit before_{};
  void (*handler_)(int) = nullptr;
};

TEST(Appliance, Row21AFullDiskIsNotVisible) {
  const auto rig = running({.name = "row21"});
  rig->advance(12s);
  const auto state = load_turbidity_state(rig->folder / "state");
  ASSERT_TRUE(state) << "saved as often as asked";
  {
    const FullDisk full;
    for (int i = 0; i < 4; ++i) {
      rig->advance(5s);
      ASSERT_EQ(rig->shown(), Shown::live);
    }
  }
  EXPECT_EQ(load_turbidity_state(rig->folder / "state").value().utc, state->utc) << "the old file stays intact";
  rig->advance(12s);
  EXPECT_GT(load_turbidity_state(rig->folder / "state").value().utc, state->utc);
  std::printf("%-52s when free, next write\n", "21 disk full");
}

TEST(Appliance, Row21AReadOnlyStateFolderIsNotVisible) {
  Rig rig({.name = "row21-folder"});
  std::filesystem::remove_all(rig.folder / "state");
  ASSERT_TRUE(write_text_file(rig.folder / "state", "a file where a folder should be"));
  rig.advance(25s);
  EXPECT_EQ(rig.shown(), Shown::live);
}

TEST(Appliance, Row22KilledAtAnyMomentTheStateIsOldOrNewAndIntact) {
  const auto folder = test_output_folder() / "pipeline" / "row22";
  std::filesystem::create_directories(folder);
  std::mt19937_64 random(3);
  ASSERT_TRUE(save({{2.0}, 0.1, Utc{1s}}, folder));
  double last = 2.0;
  for (int cut = 0; cut < 40; ++cut) {
    const auto child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      for (int i = 1;; ++i) (void)save({{last + 1e-6 * i}, 0.1, Utc{std::chrono::seconds(i)}}, folder);
    }
    std::this_thread::sleep_for(std::chrono::microseconds(random() % 15'000));
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    const auto state = load_turbidity_state(folder);
    ASSERT_TRUE(state) << state.error().message;
    EXPECT_GE(state->turbidity.value, last);
    last = state->turbidity.value;
  }
  EXPECT_GT(last, 2.0) << "the child did write";
  std::printf("%-52s whole after each of 40 cuts\n", "22 power cut while state is written");
}

TEST(TurbidityState, NonsenseOnDiskIsRejected) {
  const auto folder = test_output_folder() / "pipeline" / "state-nonsense";
  std::filesystem::create_directories(folder);
  for (const char* text : {"", "{", "[]", "null", "{\"turbidity\": 3}",
                           "{\"turbidity\": 0.5, \"sigma\": 0.1, \"utc\": \"2026-06-21T03:00:00Z\"}",
                           "{\"turbidity\": 3, \"sigma\": -1, \"utc\": \"2026-06-21T03:00:00Z\"}",
                           "{\"turbidity\": 3, \"sigma\": 0.1, \"utc\": \"yesterday\"}",
                           "{\"turbidity\": \"3\", \"sigma\": 0.1, \"utc\": 5}",
                           "{\"turbidity\": 3, \"sigma\": 0.1, \"utc\": \"2026-06-21T03:00:00Z\", \"sky_model\": 3}",
                           "{\"turbidity\": 3, \"sigma\": 0.1, \"utc\": \"2026-06-21T03:00:00Z\", \"sky_model\": "
                           "\"automatic\"}"}) {
    ASSERT_TRUE(write_text_file(folder / "turbidity.json", text));
    EXPECT_FALSE(load_turbidity_state(folder)) << text;
  }
}

TEST(TurbidityState, BelongsToTheAerosolThatWasFitted) {
  const auto folder = test_output_folder() / "pipeline" / "state-aerosol";
  std::filesystem::create_directories(folder);
  const SkyToFit dust{SiteSkyModel::dome, 300.0, Aerosol{0.1, -0.12, AerosolKind::dust}};
  ASSERT_TRUE(save(turbidity_state({14.9}, 0.7, Utc{}, dust), folder));
  const auto kept = load_turbidity_state(folder);
  ASSERT_TRUE(kept.has_value());
  EXPECT_TRUE(kept->belongs_to(dust));
  EXPECT_FALSE(kept->belongs_to({SiteSkyModel::dome, 300.0, Aerosol{0.1, 1.32, AerosolKind::continental}}));
  EXPECT_FALSE(kept->belongs_to({SiteSkyModel::dome, 300.0, Aerosol{0.1, 0.3, AerosolKind::dust}}));
  EXPECT_FALSE(kept->belongs_to({SiteSkyModel::dome, 300.0, std::nullopt}));
}

TEST(TurbidityState, KeepsTheSkyModelWhichIsPreethamInOldFiles) {
  const auto folder = test_output_folder() / "pipeline" / "state-model";
  std::filesystem::create_directories(folder);
  ASSERT_TRUE(save({{4.0}, 0.1, Utc{1s}, SiteSkyModel::dome}, folder));
  EXPECT_EQ(load_turbidity_state(folder).value().sky_model, SiteSkyModel::dome);
  ASSERT_TRUE(write_text_file(folder / "turbidity.json",
                              "{\"turbidity\": 3, \"sigma\": 0.1, \"utc\": \"2026-06-21T03:00:00Z\"}"));
  EXPECT_EQ(load_turbidity_state(folder).value().sky_model, SiteSkyModel::preetham);
}

class BrokenContent : public testing::TestWithParam<int> {};

TEST_P(BrokenContent, Row23TheOldContentStaysAndEveryProblemIsReported) {
  const auto rig = running({.name = fmt::format("row23-{}", GetParam())});
  std::string expected;
  switch (GetParam()) {
    case 0:  // configuration: two problems at once
      replace_in(rig->config, "policy = \"trusted\"", "policy = \"trsuted\"");
      replace_in(rig->config, "latitude_deg = ", "latitude_deg = 1000 #");
      expected = "latitude_deg";
      break;
    case 1:  // not TOML
      ASSERT_TRUE(write_text_file(rig->config, "[site"));
      expected = "not valid TOML";
      break;
    case 2: {  // model
      auto bytes = read_file(rig->folder / "temple.glb").value();
      bytes.resize(bytes.size() / 3);
      ASSERT_TRUE(write_file(rig->folder / "temple.glb", bytes));
      expected = "temple.glb";
      break;
    }
    case 3:  // mask
      ASSERT_TRUE(write_text_file(rig->folder / "scene-mask.png", "not a picture"));
      expected = "mask";
      break;
    case 4:  // still picture
      ASSERT_TRUE(write_text_file(rig->folder / "still.png", "not a picture"));
      expected = "still.picture";
      break;
    case 5:  // calibration
      replace_in(rig->config, "model = \"equidistant\"", "model = \"fisheye\"");
      expected = "sky.lens.model";
      break;
    default:  // gone
      std::filesystem::remove(rig->config);
      expected = "kasumi.toml";
  }
  rig->hang_up();
  for (int i = 0; i < 100; ++i) {
    rig->advance(Rig::kTick);
    ASSERT_EQ(rig->shown(), Shown::live);
  }
  ASSERT_TRUE(rig->status().reload);
  EXPECT_THAT(testing::PrintToString(rig->status().reload->problems), HasSubstr(expected));
  if (GetParam() == 0) {
    EXPECT_THAT(testing::PrintToString(rig->status().reload->problems), HasSubstr("trsuted"));
  }
  EXPECT_EQ(rig->notifier.reloads, 1);
  std::printf("23 broken content, kind %d %-28s old one runs on\n", GetParam(), "");
}
INSTANTIATE_TEST_SUITE_P(Kinds, BrokenContent, testing::Range(0, 7));

TEST(Appliance, ValidContentIsReloadedWithoutAGap) {
  const auto rig = running({.name = "reload"});
  const auto opened = rig->status().scene_camera.health.opened;
  replace_in(rig->config, "language = \"en\"", "language = \"ja\"");
  for (int moment = 0; moment < 10; ++moment) {  // between two frames of the camera
    rig->hang_up();
    for (Duration turned{}; turned < 420ms + moment * 20ms; turned += Rig::kTick) {
      rig->advance(Rig::kTick);
      ASSERT_NE(rig->shown(), Shown::still);
      const auto age = rig->age_on_screen();
      ASSERT_TRUE(age) << "there is always a picture of the scene";
      ASSERT_LE(*age, 220ms);
    }
  }
  EXPECT_EQ(rig->shown(), Shown::live);
  ASSERT_TRUE(rig->status().reload);
  EXPECT_TRUE(rig->status().reload->problems.empty());
  EXPECT_EQ(rig->status().scene_camera.health.opened, opened) << "a camera that stays the same is left alone";
}

TEST(Appliance, AnotherCameraIsOpenedInsteadOfTheOldOne) {
  const auto rig = running({.name = "reload-camera"});
  const auto other = rig->folder / "other";
  std::filesystem::copy(bench_fixture(), other, std::filesystem::copy_options::recursive);
  auto text = read_text_file(rig->config).value();
  const auto at = text.rfind(fmt::format("fixture = \"{}\"", bench_fixture().string()));
  text.replace(at, text.find('\n', at) - at, "fixture = \"other\"");
  ASSERT_TRUE(write_text_file(rig->config, text));
  rig->hang_up();
  rig->advance(100ms);
  EXPECT_TRUE(rig->recover("reload with another scene camera", 3s));
  EXPECT_EQ(rig->status().scene_camera.health.opened, 1u) << "of the new camera";
}

TEST(Appliance, TheStatusFileHasEveryDocumentedKey) {
  const auto rig = running({.name = "status"});
  const auto json = nlohmann::json::parse(read_text_file(rig->folder / "status.json").value());
  for (const char* key :
       {"shown", "reason", "display", "scene_camera", "sky_camera", "turbidity", "sigma", "turbidity_age_s", "sky",
        "clock_trusted", "recording", "latency_ms", "pictures", "pid", "since_utc"})
    EXPECT_TRUE(json.contains(key)) << key;
  for (const char* key : {"up", "description", "flips", "flip_timeouts", "resets"})
    EXPECT_TRUE(json["display"].contains(key)) << key;
  for (const char* camera : {"scene_camera", "sky_camera"})
    for (const char* key : {"up", "cause", "good_frames", "bad_frames", "reopened", "sequence_gaps", "backwards",
                            "mode_changes", "condition", "last_outage_s", "opened", "copied"})
      EXPECT_TRUE(json[camera].contains(key)) << camera << "." << key;
  EXPECT_EQ(json["shown"], "live");
  EXPECT_EQ(json["clock_trusted"], true);
  // The clock stands still while a picture is drawn: a frame is on the screen in the tick it arrived.
  EXPECT_LE(json["latency_ms"]["max"].get<double>(), 21.0);
}

// `recording` says no; nothing on the disk may say otherwise.
TEST(Appliance, NoPictureOfVisitorsIsKept) {
  const auto rig = running({.name = "keeps-nothing"});
  std::set<std::filesystem::path> before;
  const auto files = [&] {
    std::set<std::filesystem::path> found;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(rig->folder)) found.insert(entry.path());
    return found;
  };
  rig->advance(12s);  // the state is there
  before = files();
  rig->advance(20s);
  rig->devices.scene.unplugged = true;
  rig->advance(10s);
  EXPECT_EQ(files(), before) << "status.json and the state, written over and over";
  EXPECT_LE(std::filesystem::file_size(rig->folder / "state" / "turbidity.json"), 1000u);
  EXPECT_EQ(nlohmann::json::parse(read_text_file(rig->folder / "status.json").value())["recording"], false);
}

}  // namespace
}  // namespace kasumi
