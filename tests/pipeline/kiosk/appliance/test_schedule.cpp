// What a day brings by itself: eras, a television that is woken and put to sleep, and what operators read meanwhile.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "base/outside/json_text.hpp"
#include "pipeline/kiosk/doctor/checks.hpp"
#include "pipeline/site/files/picture_sink.hpp"
#include "tests/must.hpp"
#include "tests/picture_difference.hpp"
#include "tests/pipeline/kiosk/appliance/rig.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

using namespace std::chrono;
using testing::ElementsAre;
using testing::HasSubstr;

// The recording's noon is 03:00 UTC in Japan.
constexpr auto kDay = sys_days{June / 21 / 2026};

nlohmann::json status_of(const Rig& rig) {
  rig.status();
  return parse_json(read_text_file(rig.folder / "status.json").value());
}

constexpr const char* kTwoEras =
    "\n[opening]\ntime_zone = \"UTC\"\n"
    "[[era]]\nname = \"temple\"\nhours = \"00:00-03:01\"\n"
    "[[era]]\nname = \"pagoda\"\nhours = \"03:01-24:00\"\nmodel = \"pagoda.glb\"\n"
    "picture = \"other-still.png\"\ncaption = \"The pagoda returns.\"\n";

RigOptions with_eras(const std::string& name, Utc utc) {
  RigOptions options{.name = name, .more_config = kTwoEras};
  options.utc = utc;
  options.keep_folder = true;
  const auto folder = test_folder("appliance-" + name);
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  std::filesystem::copy_file(source_folder() / "fixtures/pagoda.glb", folder / "pagoda.glb");
  EXPECT_TRUE(write_png(folder / "other-still.png", Image<Rgb8>(320, 180, Rgb8{10, 200, 20})));
  return options;
}

TEST(Schedule, AnEraFollowsTheOtherWithoutADarkOrStillPictureAndWithoutTheDisk) {
  const auto rig = running(with_eras("era-change", kDay + 3h + 45s));
  EXPECT_EQ(status_of(*rig)["content"]["era"], "temple");
  const auto before = rig->picture();
  // Everything was read: the files may even be gone.
  for (const char* file : {"pagoda.glb", "other-still.png", "temple.glb", "kasumi.toml"})
    std::filesystem::remove(rig->folder / file);
  const int opened = rig->devices.scene.opened;
  const auto air = rig->status().sky.report.air;
  ASSERT_TRUE(air && air->seen());
  std::optional<Utc> changed;
  for (int i = 0; i < 1500 && !changed; ++i) {
    rig->advance(Rig::kTick);
    ASSERT_EQ(rig->shown(), Shown::live) << "at " << duration<double>(rig->clock.utc() - kDay).count();
    ASSERT_TRUE(rig->status().render.building_drawn) << "the land without a building is a flash too";
    ASSERT_LE(to_seconds(*rig->age_on_screen()), 1.0);
    if (status_of(*rig)["content"]["era"] == "pagoda") changed = rig->clock.utc();
  }
  ASSERT_TRUE(changed);
  EXPECT_GE(*changed - kDay, 3h + 1min);
  EXPECT_LE(*changed - kDay, 3h + 1min + 10s);
  rig->advance(2s);
  EXPECT_EQ(rig->devices.scene.opened, opened) << "the cameras go on";
  EXPECT_EQ(rig->devices.display.opened, 1);
  EXPECT_EQ(rig->notifier.reloads, 0) << "the service manager has nothing to do with it";
  const auto later = rig->status().sky.report.air;
  ASSERT_TRUE(later && later->seen());
  EXPECT_NEAR(later->air.turbidity().value, air->air.turbidity().value, 0.2) << "the air stays known";
  EXPECT_GT(difference(before, rig->picture()).mean, 0.3) << "another building";
  EXPECT_TRUE(status_of(*rig)["content"]["era_problem"].is_null());

  rig->devices.scene.unplugged = true;
  ASSERT_TRUE(rig->advance_until([&] { return rig->shown() == Shown::still; }, 10s));
  rig->advance(1s);
  const auto colour = rig->picture().at(10, 10);
  EXPECT_NEAR(colour.g, 200, 3) << "the era's own still picture";
}

TEST(Schedule, TheNextStartShowsTheEraOfItsHour) {
  const auto rig = running(with_eras("era-start", kDay + 3h + 2min));
  EXPECT_EQ(status_of(*rig)["content"]["era"], "pagoda");
  rig->hang_up();
  ASSERT_TRUE(rig->advance_until([&] { return rig->status().reload && rig->status().reload->ended; }, 20s));
  EXPECT_THAT(rig->status().reload->problems, ElementsAre());
  EXPECT_EQ(status_of(*rig)["content"]["era"], "pagoda") << "and so does a reload";
}

TEST(Schedule, AnEraThatDoesNotFitIsToldAndTheOneBeforeStays) {
  auto options = with_eras("era-memory", kDay + 3h + 45s);
  options.observe_every = kSeldom;
  bool little = false;
  options.probes.memory_left = [&] { return little ? 1'000'000u : 8'000'000'000u; };
  const auto rig = running(std::move(options));
  little = true;
  rig->advance(40s);
  EXPECT_EQ(rig->shown(), Shown::live);
  auto content = status_of(*rig)["content"];
  EXPECT_EQ(content["era"], "temple");
  EXPECT_THAT(content["era_problem"].get<std::string>(), HasSubstr("\"pagoda\" cannot be shown"));
  little = false;
  rig->advance(10min, 5s);
  rig->advance(20s, 1s);
  content = status_of(*rig)["content"];
  EXPECT_EQ(content["era"], "pagoda") << "tried again";
  EXPECT_TRUE(content["era_problem"].is_null());
}

TEST(Schedule, WhileTheClockIsNotTrustedTheEraStays) {
  auto options = with_eras("era-clock", kDay + 3h + 45s);
  options.clock_policy = "synchronized";
  Rig rig(options);
  rig.advance(40s);
  EXPECT_EQ(status_of(rig)["content"]["era"], "temple");
  rig.time.state = {.synchronized = true, .jumps = 1};
  rig.advance(15s);
  EXPECT_EQ(status_of(rig)["content"]["era"], "pagoda");
}

TEST(Schedule, EveryErasMistakesAreNamedAtOnce) {
  const auto rig = running({.name = "era-mistakes"});
  replace_in(rig->config, "[state]",
             "[[era]]\nname = \"a\"\ndates = \"01-01..06-30\"\nscene = \"atlantis\"\n"
             "[[era]]\nname = \"b\"\ndates = \"06-30..12-30\"\nmodel = \"gone.glb\"\ncaptoin = \"b\"\n[state]");
  rig->hang_up();
  rig->advance(100ms);
  const auto problems = testing::PrintToString(rig->status().reload->problems);
  for (const char* expected : {"both shown on 06-30", "none is shown on 12-31", "atlantis", "gone.glb", "captoin"})
    EXPECT_THAT(problems, HasSubstr(expected));
  EXPECT_EQ(rig->shown(), Shown::live);
}

TEST(Schedule, TheScreenAndTheTelevisionWakeBeforeOpeningAndSleepAfterwards) {
  RigOptions options{.name = "wake",
                     .more_config =
                         "\n[opening]\ntime_zone = \"UTC\"\nwake_before_min = 2\n"
                         "every_day = \"03:04-03:05\"\n"};
  options.utc = kDay + 3h;
  options.observe_every = kSeldom;
  Rig rig(options);
  replace_in(rig.config, "[display]\n", "[display]\ncec = \"/dev/cec0\"\n");
  rig.hang_up();
  auto& tv = rig.devices.television;
  tv.on = true;
  rig.advance(90s, 100ms);
  EXPECT_TRUE(rig.devices.display.off);
  EXPECT_FALSE(tv.on) << "closed since the start";

  ASSERT_TRUE(rig.advance_until([&] { return !rig.devices.display.off; }, 60s));
  EXPECT_EQ(duration_cast<seconds>(rig.clock.utc() - kDay), 3h + 2min) << "two minutes before opening";
  rig.advance(15s);
  EXPECT_TRUE(tv.on);
  EXPECT_EQ(tv.active, tv.place);
  EXPECT_EQ(rig.shown(), Shown::live);
  auto television = status_of(rig)["television"];
  EXPECT_EQ(television["wanted"], "on");
  EXPECT_EQ(television["power"], "on");
  EXPECT_EQ(television["answers"], true);

  rig.advance(180s, 100ms);
  EXPECT_TRUE(rig.devices.display.off);
  EXPECT_FALSE(tv.on);
  EXPECT_EQ(status_of(rig)["television"]["wanted"], "standby");
}

TEST(Schedule, ATelevisionThatDoesNotAnswerCostsNoPicture) {
  const auto rig = running({.name = "mute-television"});
  rig->devices.television.there = false;
  replace_in(rig->config, "[display]\n", "[display]\ncec = \"/dev/cec0\"\n");
  rig->hang_up();
  rig->advance(30s);
  EXPECT_EQ(rig->shown(), Shown::live);
  EXPECT_EQ(status_of(*rig)["television"]["answers"], false);
  const auto opened = rig->devices.television.opened;
  rig->advance(1min, 200ms);
  EXPECT_LE(rig->devices.television.opened, std::max(opened, 4));
}

TEST(Schedule, ClosedLooksWellToTheDoctor) {
  RigOptions options{.name = "closed-well",
                     .more_config = "\n[opening]\ntime_zone = \"UTC\"\nevery_day = \"closed\"\n"};
  Rig rig(options);
  rig.advance(10s);
  ASSERT_EQ(rig.shown(), Shown::dark);
  const auto now = [&] {
    rig.status();
    return RunningAppliance{1, read_text_file(rig.folder / "status.json").value(), 0.5};
  };
  const auto before = now();
  rig.advance(5s);
  Findings findings;
  check_appliance(read_content(rig.config).value()->config, before, now(), 5.0, findings);
  for (const auto& finding : findings.all())
    EXPECT_EQ(finding.grade, Grade::good) << finding.check << ": " << finding.found;
}

}  // namespace
}  // namespace kasumi
