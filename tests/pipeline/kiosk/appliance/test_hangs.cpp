// A camera's call that never returns: what visitors and operators see, and what then happens (design: faults, row 30).
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "base/outside/json_text.hpp"
#include "pipeline/kiosk/doctor/checks.hpp"
#include "tests/pipeline/kiosk/appliance/journal.hpp"
#include "tests/pipeline/kiosk/appliance/rig.hpp"
#include "tests/pipeline/recorded.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;
using testing::Not;

nlohmann::json status_json_of(const Rig& rig) {
  rig.status();
  return parse_json(read_text_file(rig.folder / "status.json").value());
}

Finding doctor_says(const Rig& rig, const std::string& check) {
  const auto text = status_json_of(rig).dump();
  Findings findings;
  check_appliance({}, {4711, text, 0.1}, {4711, text, 0.1}, 3.0, findings);
  for (const auto& finding : findings.all())
    if (finding.check == check) return finding;
  return {};
}

constexpr Duration kLongStep = 1s;  // of the clock, where nothing quick happens: each step draws a picture

// A rig whose picture is live, in few steps.
std::unique_ptr<Rig> live(RigOptions options) {
  auto rig = std::make_unique<Rig>(std::move(options));
  rig->advance(4s, 200ms);
  EXPECT_EQ(rig->shown(), Shown::live) << name_of(rig->trouble());
  EXPECT_TRUE(rig->status().sky.report.seen_air()) << rig->status().sky.report.estimate.reason;
  return rig;
}

// Lets the camera's next call hang.
void hang(Rig& rig, CameraFaults& camera) {
  camera.trap.set();
  ASSERT_TRUE(rig.advance_until([&] { return camera.trap.caught(); }, 2s));
}

TEST(Appliance, Row30AHungSkyCameraIsAsIfItWereGone) {
  const auto rig = live({.name = "row30-sky", .observe_every = 1s});
  const Journal journal;
  const auto air = rig->status().sky.report.seen_air()->air.turbidity().value;
  const auto sun = rig->status().sky.report.sun.direction;
  hang(*rig, rig->devices.sky);
  rig->advance(7s, kLongStep);
  EXPECT_EQ(rig->shown(), Shown::degraded);
  EXPECT_EQ(rig->trouble(), Trouble::sky_lost);
  EXPECT_TRUE(rig->age_on_screen()) << "the scene camera is well";
  rig->advance(30s, kLongStep);
  auto json = status_json_of(*rig);
  EXPECT_EQ(json["shown"], "degraded");
  EXPECT_EQ(json["sky_camera"]["up"], false);
  EXPECT_THAT(json["sky_camera"]["cause"].get<std::string>(), HasSubstr("hung"));
  EXPECT_NEAR(json["sky_camera"]["told_age_s"].get<double>(), 37.0, 1.5);
  EXPECT_NEAR(json["sky_camera"]["down_s"].get<double>(), 37.0, 1.5);
  EXPECT_THAT(json["sky_reason"].get<std::string>(), HasSubstr("hung"));
  EXPECT_NEAR(json["turbidity_age_s"].get<double>(), 37.0, 2.0);
  EXPECT_NEAR(json["air"]["age_s"].get<double>(), 37.0, 2.0);
  EXPECT_NEAR(json["turbidity"].get<double>(), air, 0.02);
  EXPECT_EQ(json["loops"]["sky"]["up"], false);
  EXPECT_EQ(json["loops"]["scene"]["up"], true);
  EXPECT_EQ(doctor_says(*rig, "loops").grade, Grade::failure);
  EXPECT_THAT(doctor_says(*rig, "loops").found, HasSubstr("sky loop"));
  EXPECT_EQ(doctor_says(*rig, "sky_camera.open").grade, Grade::failure);
  EXPECT_THAT(rig->notifier.lines.back(), HasSubstr("sky loop: hung"));
  EXPECT_EQ(journal.count("sky loop: hung"), 1) << journal.text();

  rig->advance(150s, 3s);
  const auto& later = rig->status().sky.report.sun;
  EXPECT_EQ(later.source, SunSource::ephemeris);
  const double moved_deg =
      std::acos(std::min(1.0, glm::dot(glm::dvec3(sun.x, sun.y, sun.z),
                                       glm::dvec3(later.direction.x, later.direction.y, later.direction.z)))) *
      180.0 / 3.14159265;
  EXPECT_GT(moved_deg, 0.5) << "the sun does not wait";
  EXPECT_FALSE(rig->status().sky.report.measured) << "clouds of minutes ago have moved on";

  rig->let_go(rig->devices.sky);
  EXPECT_TRUE(rig->recover("30 sky camera's call returns", 5s));
  EXPECT_EQ(journal.count("sky loop: back"), 1) << journal.text();
  EXPECT_EQ(doctor_says(*rig, "loops").grade, Grade::good);
}

TEST(Appliance, Row30AHungSceneCameraIsAsIfItWereGone) {
  const auto rig = live({.name = "row30-scene"});
  const Journal journal;
  hang(*rig, rig->devices.scene);
  rig->advance(1s);
  EXPECT_EQ(rig->shown(), Shown::held);
  rig->advance(2s);
  EXPECT_EQ(rig->shown(), Shown::still);
  EXPECT_TRUE(rig->shows_still());
  rig->advance(20s, kLongStep);
  const auto json = status_json_of(*rig);
  EXPECT_EQ(json["scene_camera"]["up"], false);
  EXPECT_THAT(json["scene_camera"]["cause"].get<std::string>(), HasSubstr("hung"));
  EXPECT_NEAR(json["scene_camera"]["last_good_age_s"].get<double>(), 23.0, 1.0);
  EXPECT_EQ(json["sky_camera"]["up"], true);
  EXPECT_LT(json["turbidity_age_s"].get<double>(), 3.0);
  EXPECT_EQ(doctor_says(*rig, "scene_camera.open").grade, Grade::failure);
  EXPECT_EQ(journal.count("scene loop: hung"), 1) << journal.text();
  rig->let_go(rig->devices.scene);
  EXPECT_TRUE(rig->recover("30 scene camera's call returns", 5s));
}

TEST(Appliance, Row30AfterAMinuteTheWatchdogIsNoLongerFed) {
  for (const bool scene : {false, true}) {
    const auto rig = live({.name = scene ? "row30-watchdog-scene" : "row30-watchdog-sky"});
    auto& camera = scene ? rig->devices.scene : rig->devices.sky;
    hang(*rig, camera);
    auto alives = rig->notifier.alives;
    rig->advance(59s, kLongStep);
    EXPECT_GE(rig->notifier.alives, alives + 55) << "it may yet return";
    rig->advance(2s, kLongStep);
    alives = rig->notifier.alives;
    rig->advance(20s, kLongStep);
    EXPECT_EQ(rig->notifier.alives, alives) << "the service manager restarts the service";
    rig->let_go(camera);
    rig->advance(5s, kLongStep);
    EXPECT_GE(rig->notifier.alives, alives + 3) << "it returned before the service manager acted";
  }
}

// As a television that is switched off while a camera's driver hangs.
TEST(Appliance, Row30TheWatchdogIsWithheldWithoutADisplayAsWell) {
  Rig rig({.name = "row30-no-display", .display = {.unplugged = true}});
  rig.advance(2s, 200ms);
  hang(rig, rig.devices.scene);
  rig.advance(62s, kLongStep);
  const auto alives = rig.notifier.alives, extensions = rig.notifier.extensions;
  rig.advance(20s, kLongStep);
  EXPECT_EQ(rig.notifier.alives, alives);
  EXPECT_EQ(rig.notifier.extensions, extensions) << "a start that waits is not extended either";
  rig.let_go(rig.devices.scene);
}

// The watchdog ends the program after each, and the next start leaves that camera alone for a while.
TEST(Appliance, Row30ACameraThatHangsAtEveryOpeningRestsOverRestarts) {
  const auto state = test_folder("row30-starts");
  std::filesystem::remove_all(state);
  std::filesystem::create_directories(state);
  int times = 0;
  for (const auto rest : {0min, 1min, 2min}) {
    StartLog starts({state, {}}, "boot", 15.0);
    Rig rig({.name = "row30-starts", .starts = &starts});
    rig.devices.scene.trap.set();
    if (rest > 0min) {
      rig.advance(3s, kLongStep);
      EXPECT_EQ(rig.shown(), Shown::still);
      EXPECT_TRUE(rig.status().sky_camera.health.up) << "the other one is not left alone";
      EXPECT_THAT(rig.status().scene_camera.health.cause,
                  HasSubstr(fmt::format("left alone for {} min: its opening hung", rest.count())));
      rig.clock.advance(rest - 10s);
      rig.advance(5s, kLongStep);
      EXPECT_EQ(rig.devices.scene.opened, 0);
    }
    ASSERT_TRUE(rig.advance_until([&] { return rig.devices.scene.trap.caught(); }, 30s)) << "it is tried again";
    const auto on_disk = [&] {
      const auto text = read_text_file(state / "starts.json");  // not there before a picture is shown, or 5 s are over
      return text ? parse_json(*text)["hung_openings"].value("scene", 0) : 0;
    };
    rig.advance(29s, kLongStep);
    EXPECT_EQ(on_disk(), times) << "it may be slow";
    const auto alives = rig.notifier.alives;
    rig.advance(3s, kLongStep);
    EXPECT_GT(rig.notifier.alives, alives) << "it is on the disk before the watchdog bites";
    EXPECT_EQ(on_disk(), ++times);
  }
}

TEST(Appliance, Row30ARenderLoopThatHangsIsToldByTheStatus) {
  const auto rig = live({.name = "row30-render"});
  const Journal journal;
  rig->render_hangs = true;
  rig->advance(15s, kLongStep);
  const auto json = status_json_of(*rig);
  EXPECT_EQ(json["shown"], "held") << "the last picture stays on the screen";
  EXPECT_EQ(json["loops"]["render"]["up"], false);
  EXPECT_EQ(journal.count("render loop: hung"), 1) << journal.text();
}

TEST(Appliance, Row15NothingIsCalledLiveWithoutADisplay) {
  const auto rig = live({.name = "row15-shown"});
  const Journal journal;
  rig->devices.display.unplugged = true;
  rig->devices.display.context_lost = true;
  rig->advance(3s, 200ms);
  const auto json = status_json_of(*rig);
  EXPECT_EQ(json["display"]["up"], false);
  EXPECT_EQ(json["shown"], "nothing");
  EXPECT_EQ(json["reason"], "no display");
  EXPECT_EQ(doctor_says(*rig, "service").grade, Grade::warning);
  EXPECT_THAT(journal.text(), HasSubstr("shown: nothing: no display"));
  rig->devices.display.unplugged = false;
  EXPECT_TRUE(rig->recover("15 the display is back", 3s));
  rig->appliance->render().finish();
  EXPECT_NE(status_json_of(*rig)["shown"], "live") << "it has ended";
}

TEST(Pulse, ALoopHangsWhenItIsSilentForLongerThanItSaid) {
  Pulse pulse("sky");
  Instant now{100s};
  EXPECT_FALSE(pulse.hung(now)) << "it has not begun";
  pulse.turn(now, 5s);
  EXPECT_FALSE(pulse.hung(now + 5s));
  EXPECT_EQ(pulse.hung(now + 6s), std::optional<Duration>(6s));
  pulse.turn(now + 6s, 30s);
  EXPECT_FALSE(pulse.hung(now + 30s)) << "it said that it computes";
}

}  // namespace
}  // namespace kasumi
