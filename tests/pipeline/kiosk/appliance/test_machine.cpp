// What may go wrong with display, disk, service and content (design: faults, by row).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <fstream>
#include <random>
#include <set>
#include <sstream>
#include <thread>

#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>
#include <sys/wait.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "base/outside/json_text.hpp"
#include "capture/codec/encode.hpp"
#include "pipeline/kiosk/start/remembered_state.hpp"
#include "pipeline/machine/camera_acceptance.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/kiosk/appliance/rig.hpp"
#include "tests/pipeline/run_kasumi.hpp"
#include "tests/places.hpp"
#include "tests/small_disk.hpp"

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
  const auto took = must(rig->recover("17 GL context lost", 2s));
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

TEST(Appliance, Row21AFullDiskIsNotVisible) {
  const auto rig = running({.name = "row21"});
  rig->advance(12s);
  const auto state = load_turbidity_state(rig->folder / "state");
  ASSERT_TRUE(state) << "saved as often as asked";
  {
    const SmallDisk full(0);
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
    const auto state = must(load_turbidity_state(folder));
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
  const ModelToFit dust{DaylightModel::dome, 300.0, Aerosol{0.1, -0.12, AerosolKind::dust}};
  ASSERT_TRUE(save(turbidity_state({14.9}, 0.7, Utc{}, dust), folder));
  const auto kept = must(load_turbidity_state(folder));
  EXPECT_TRUE(kept->belongs_to(dust));
  EXPECT_FALSE(kept->belongs_to({DaylightModel::dome, 300.0, Aerosol{0.1, 1.32, AerosolKind::continental}}));
  EXPECT_FALSE(kept->belongs_to({DaylightModel::dome, 300.0, Aerosol{0.1, 0.3, AerosolKind::dust}}));
  EXPECT_FALSE(kept->belongs_to({DaylightModel::dome, 300.0, std::nullopt}));
}

TEST(TurbidityState, KeepsTheSkyModelWhichIsPreethamInOldFiles) {
  const auto folder = test_output_folder() / "pipeline" / "state-model";
  std::filesystem::create_directories(folder);
  ASSERT_TRUE(save({{4.0}, 0.1, Utc{1s}, DaylightModel::dome}, folder));
  EXPECT_EQ(load_turbidity_state(folder).value().sky_model, DaylightModel::dome);
  ASSERT_TRUE(write_text_file(folder / "turbidity.json",
                              "{\"turbidity\": 3, \"sigma\": 0.1, \"utc\": \"2026-06-21T03:00:00Z\"}"));
  EXPECT_EQ(load_turbidity_state(folder).value().sky_model, DaylightModel::preetham);
}

TEST(TurbidityState, KeepsTheWholeStateOfTheAir) {
  const auto folder = test_output_folder() / "pipeline" / "state-air";
  std::filesystem::create_directories(folder);
  ModelToFit every_model{DaylightModel::preetham, 300.0};
  every_model.every_model = true;
  auto state = turbidity_state({4.1}, 0.3, Utc{1s}, every_model);
  state.air = RememberedAir{{0.31, 0.4, AerosolKind::desert}, 0.02, 0.1, false, 1.7, 0.2, Utc{1s}};
  ASSERT_TRUE(save(state, folder));
  const auto kept = load_turbidity_state(folder).value();
  EXPECT_EQ(kept.air, state.air);
  EXPECT_TRUE(kept.belongs_to(every_model));
  EXPECT_TRUE(kept.belongs_to({DaylightModel::dome, 300.0})) << "an optical depth means the same to both";
  EXPECT_FALSE(kept.belongs_to({DaylightModel::preetham, 300.0})) << "where T alone is followed";

  const auto text = read_text_file(folder / "turbidity.json").value();
  for (const auto& [good, bad] :
       {std::pair{"0.31", "-0.31"}, std::pair{"0.31", "31.0"}, std::pair{"\"desert\"", "\"sand\""},
        std::pair{"1.7", "0.0"}, std::pair{"false", "0"}}) {
    auto damaged = text;
    ASSERT_NE(damaged.find(good), std::string::npos);
    damaged.replace(damaged.find(good), std::string(good).size(), bad);
    ASSERT_TRUE(write_text_file(folder / "turbidity.json", damaged));
    EXPECT_FALSE(load_turbidity_state(folder)) << damaged;
  }
}

// A closed sky, and a wood of known distance before the scene camera.
TEST(Appliance, Row29UnderAClosedSkyLandmarksCarryTheAirAndWithoutItIsSupposed) {
  ObservationPlan sky;
  sky.estimator = [](const SkyPicture&, const SunDirection&) {
    TurbidityEstimate estimate;
    estimate.sky = SkyCondition::overcast;
    estimate.reason = "overcast";
    return estimate;
  };
  Rig nobody({.name = "supposed", .sky = sky});
  nobody.advance(4s);
  ASSERT_TRUE(nobody.status().sky.report.air);
  EXPECT_TRUE(nobody.status().sky.report.air->supposed);
  EXPECT_THAT(status_line(nobody.status()), testing::HasSubstr("the air is supposed"));
  EXPECT_EQ(parse_json(status_json(nobody.status()))["air"]["supposed"], true);
  EXPECT_TRUE(parse_json(status_json(nobody.status()))["turbidity"].is_null());

  Rig rig({.name = "landmarks",
           .more_config = "\n[[landmarks]]\nname = \"wood\"\ndistance_m = 3000\nregion_px = [20, 150, 40, 10]\n",
           .sky = sky});
  rig.advance(5s);
  ASSERT_TRUE(rig.status().visibility.air) << rig.status().visibility.reason;
  const auto& state = rig.status().sky.report.air;
  EXPECT_FALSE(state->supposed) << state->text();
  const auto json = parse_json(read_text_file(rig.folder / "status.json").value())["air"];
  EXPECT_EQ(json["observers"][0]["by"], "landmarks");
  EXPECT_EQ(json["supposed"], false);
  for (const char* key :
       {"text", "trustworthy", "age_s", "turbidity", "sigma", "aod_550", "sigma_aod_550", "angstrom_exponent",
        "sigma_angstrom", "aerosol", "kinds", "followed", "papers_share", "near_ground", "sigma_log_near_ground"})
    EXPECT_TRUE(json.contains(key)) << key;
  for (const char* key : {"share", "age_s", "aod_550", "sigma_aod_550", "sigmas_apart"})
    EXPECT_TRUE(json["observers"][0].contains(key)) << key;
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
    case 6: {  // a still picture that claims to be large; the display would need a thousandth of it
      auto bytes = read_file(rig->folder / "still.png").value();
      for (const std::size_t at : {18, 22}) std::tie(bytes[at], bytes[at + 1]) = std::tuple(0x27, 0x10);
      ASSERT_TRUE(write_file(rig->folder / "still.png", bytes));
      expected = "still.png: a PNG of 10000 x 10000 pixels: expected 1 .. 8192 each way";
      break;
    }
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
INSTANTIATE_TEST_SUITE_P(Kinds, BrokenContent, testing::Range(0, 8));

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

TEST(Appliance, TheStatusFileHasEveryDocumentedKey) {
  const auto rig = running({.name = "status"});
  const auto json = parse_json(read_text_file(rig->folder / "status.json").value());
  for (const char* key :
       {"shown", "reason", "display", "scene_camera", "sky_camera", "turbidity", "sigma", "turbidity_age_s", "sky",
        "clock_trusted", "recording", "air", "latency_ms", "pictures", "pid", "since_utc"})
    EXPECT_TRUE(json.contains(key)) << key;
  for (const char* key : {"up", "description", "flips", "flip_timeouts", "resets", "planes"})
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

// What no driver and no size check has stopped: the renderer refuses it, and says why.
TEST(Appliance, APictureThatCannotBeDrawnIsNamedInStatusAndJournal) {
  std::ostringstream said;
  const auto before = spdlog::default_logger();
  spdlog::set_default_logger(
      std::make_shared<spdlog::logger>("test", std::make_shared<spdlog::sinks::ostream_sink_mt>(said)));
  Rig rig({.name = "refused"});
  Mailboxes mailboxes;
  RenderLoop loop(read_content(rig.config).value(), rig.devices, rig.clock, rig.notifier, mailboxes);
  const auto refused = [&] {
    const auto frame = encode_frame(Image<Rgb8>(64, 48, Rgb8{90, 90, 90}), four_cc("RGB3")).value();
    mailboxes.render.frames.put({frame.metadata, decode(frame, YuvEncoding::bt601_full).value(), nullptr, 0});
    for (const auto step : {200ms, 0ms, 600ms}) {
      rig.clock.advance(step);
      loop.step();
    }
    return mailboxes.status->render.take().value().draw_refused;
  };
  EXPECT_EQ(refused(), "") << "one may be of the content before";
  for (int i = 0; i < 5; ++i) EXPECT_THAT(refused(), HasSubstr("64 x 48"));
  spdlog::set_default_logger(before);
  const auto text = said.str();
  const auto at = text.find("cannot be drawn");
  ASSERT_NE(at, std::string::npos) << text;
  EXPECT_EQ(text.find("cannot be drawn", at + 1), std::string::npos) << "once, not for every picture";
}

// As an installer calls it. The folder's owner is tried, not root.
TEST(Appliance, RunCheckTriesTheStatesFolder) {
  const auto folder = test_folder("appliance-check");
  std::filesystem::remove_all(folder);
  const auto config = write_config(folder);
  const auto check = [&] { return run_kasumi(fmt::format("run --check --config {}", config.string())); };
  EXPECT_EQ(check().code, 0) << check().err;
  EXPECT_TRUE(std::filesystem::is_empty(folder / "state")) << "nothing is left behind";

  std::filesystem::remove(folder / "state");
  auto outcome = check();
  EXPECT_EQ(outcome.code, 78);
  EXPECT_THAT(outcome.err, testing::AllOf(HasSubstr("[state] folder"), HasSubstr("install -d -o kasumi")));
  ASSERT_TRUE(write_text_file(folder / "state", "a file"));
  EXPECT_EQ(check().code, 78);
  std::filesystem::remove(folder / "state");
  std::filesystem::create_directory(folder / "state");
  if (::geteuid() != 0) GTEST_SKIP() << "only root changes accounts";
  ASSERT_EQ(::chown((folder / "state").c_str(), 65534, 65534), 0);
  ASSERT_EQ(::chmod((folder / "state").c_str(), 0500), 0);
  outcome = check();
  EXPECT_EQ(outcome.code, 78) << outcome.out;
  EXPECT_THAT(outcome.err, HasSubstr("may not write"));
  ASSERT_EQ(::chmod((folder / "state").c_str(), 0700), 0);
  EXPECT_EQ(check().code, 0) << check().err;
  std::filesystem::create_directory_symlink("/proc/self/fd", folder / "failing");
  replace_in(config, "folder = \"state\"", "folder = \"failing\"");
  outcome = check();
  EXPECT_EQ(outcome.code, 1) << "a disk, not the configuration: " << outcome.err;
}

// $JOURNAL_STREAM names the file that stdout and stderr are. What has no priority is a library's.
TEST(Appliance, UnderSystemdEachLineHasItsPriority) {
  const auto folder = test_folder("appliance-journal");
  std::filesystem::create_directories(folder);
  const auto said = folder / "said.txt";
  const auto lines_of = [&](const std::string& arguments, int code) {
    const auto command = fmt::format("rm -f {1}; touch {1}; JOURNAL_STREAM=$(stat -c %d:%i {1}) {0} {2} >>{1} 2>&1",
                                     kasumi_program().string(), said.string(), arguments);
    EXPECT_EQ(WEXITSTATUS(std::system(command.c_str())), code) << arguments;
    std::istringstream text(read_text_file(said).value());
    std::vector<std::string> lines;
    for (std::string line; std::getline(text, line);) lines.push_back(line);
    return lines;
  };
  using testing::Each, testing::SizeIs, testing::StartsWith, testing::Ge;
  const auto none = lines_of(fmt::format("run --config {}/none.toml", folder.string()), 78);
  EXPECT_THAT(none, SizeIs(Ge(2u)));
  EXPECT_THAT(none, Each(StartsWith("<3>")));
  for (const char* wrong : {"run", "run --confg kasumi.toml", "reload --status /nowhere/status.json"}) {
    const auto lines = lines_of(wrong, std::string(wrong).starts_with("reload") ? 1 : 2);
    EXPECT_THAT(lines, SizeIs(Ge(1u))) << wrong;
    EXPECT_THAT(lines, Each(StartsWith("<3>"))) << wrong;
  }
  EXPECT_THAT(run_kasumi("run --config none.toml").err, StartsWith("kasumi: "));
  EXPECT_THAT(run_kasumi("run").err, StartsWith("--config is required")) << "by hand nothing stands before it";
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
  EXPECT_EQ(parse_json(read_text_file(rig->folder / "status.json").value())["recording"], false);
}

// By the same rule as the appliance: what it would never show is not called valid on the desk.
TEST(CameraAcceptance, Row47AFrameOfEachCameraIsTriedBeforehand) {
  const auto folder = test_output_folder() / "pipeline" / "acceptance";
  std::filesystem::remove_all(folder);
  auto config = read_content(write_config(folder)).value()->config;
  SystemClock clock;
  std::vector<std::string> untried;
  const auto problems = [&] {
    untried.clear();
    const auto tried = try_cameras(config, *machine_devices(clock), clock, untried);
    return tried ? std::string() : tried.error().message;
  };
  EXPECT_EQ(problems(), "");
  EXPECT_TRUE(untried.empty());
  const auto right = config.installation.scene.width;
  config.installation.scene.width = 2 * right;
  EXPECT_THAT(problems(),
              testing::HasSubstr("[scene.camera]: no picture of it can be used: 320x180 instead of 640x180"));
  config.installation.scene.width = right;

  const auto recording = folder / "recording";
  std::filesystem::copy(bench_fixture(), recording, std::filesystem::copy_options::recursive);
  std::filesystem::remove_all(recording / "scene");
  config.scene_camera = ReplayCamera{recording};
  EXPECT_THAT(problems(), testing::HasSubstr("[scene.camera]: "));
  std::filesystem::copy(bench_fixture() / "scene", recording / "scene", std::filesystem::copy_options::recursive);
  EXPECT_EQ(problems(), "");
  const auto index = recording / "scene" / "index.csv";
  auto rows = read_text_file(index).value();
  for (std::size_t at = 0; (at = rows.find("RGB3,320,180,960", at)) != std::string::npos;)
    rows.replace(at, 16, "MJPG,320,180,0");
  ASSERT_TRUE(write_text_file(index, rows));
  EXPECT_THAT(problems(), testing::HasSubstr("[scene.camera]: no picture of it can be used: damaged JPEG"))
      << "as long as they have to be, and no pictures";
  config.scene_camera = V4l2Options{"/dev/kasumi-no-such-camera", {}};
  EXPECT_EQ(problems(), "") << "on the desk there is no camera";
  EXPECT_THAT(untried, testing::ElementsAre(testing::HasSubstr("scene camera: not here")));
}

}  // namespace
}  // namespace kasumi
