// Devices that come, go, hang and lie, and what is kept of their presses.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <random>
#include <set>

#include <unistd.h>

#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "base/outside/json_text.hpp"
#include "pipeline/kiosk/visitor/visitor_presses.hpp"
#include "tests/pipeline/kiosk/appliance/rig.hpp"
#include "tests/pipeline/kiosk/visitor/visited_kiosk.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

TEST(Visitor, OnlyHourAndKindArePutOnTheDisk) {
  VisitedKiosk kiosk("presses");
  kiosk.tap(KEY_L);
  kiosk.tap(KEY_L);
  kiosk.tap(KEY_P);
  kiosk.rig->advance(2s);
  kiosk.rig->appliance->status().keep();
  const auto text = read_text_file(kiosk.rig->folder / "state" / kPressesFile).value();
  EXPECT_EQ(text, "hour_utc,then_and_now,era,language,large_print,story,view\n2026-06-21T03:00:00Z,0,0,2,1,0,0\n");
}

TEST(Visitor, Row48ADeviceThatIsUnpluggedLetsGoAndComesBack) {
  VisitedKiosk kiosk("unplugged");
  kiosk.panel().key(KEY_SPACE, true);
  kiosk.rig->advance(1s);
  const auto bare = kiosk.rig->picture();
  kiosk.panel().plugged = false;
  kiosk.rig->advance(3s);
  EXPECT_GT(difference(kiosk.rig->picture(), bare, 60, 260), 0.05) << "the building is back";
  EXPECT_EQ(kiosk.rig->shown(), Shown::live);
  const auto device = kiosk.status()["visitor"]["devices"][0];
  EXPECT_EQ(device["up"], false);
  EXPECT_THAT(device["problem"].get<std::string>(), HasSubstr("no such device now"));
  kiosk.panel().queue.clear();
  kiosk.panel().plugged = true;
  kiosk.rig->advance(2s);
  EXPECT_EQ(kiosk.status()["visitor"]["devices"][0]["up"], true);
  kiosk.touch(990);
  EXPECT_LT(difference(kiosk.rig->picture(), bare, 60, 260), 0.02);
}

// Its driver answers neither to opening, nor to taking it, nor to reading.
TEST(Visitor, Row52ADeviceWhoseDriverHangsStopsNeitherPicturesNorOtherDevices) {
  for (const auto where : {&FakeInputDevice::on_open, &FakeInputDevice::on_grab, &FakeInputDevice::on_read}) {
    const std::filesystem::path hangs = "/dev/input/by-id/usb-Dead-event-kbd";
    auto config = std::string(kHand);
    config.insert(config.find("\"/dev"), fmt::format("\"{}\", ", hangs.string()));
    Trap trap;
    trap.set();
    Rig rig({.name = "hung-input", .more_config = config});
    rig.devices.input.devices[kPanel].axes[ABS_X].maximum = 1000;
    rig.devices.input.devices[hangs].*where = [&] { trap.enter(); };
    rig.advance(12s);
    ASSERT_TRUE(trap.caught());
    EXPECT_EQ(rig.shown(), Shown::live);
    const auto pictures = rig.status().render.scene_frames;
    const auto plain = rig.picture();
    rig.devices.input.devices[kPanel].key(KEY_SPACE, true);
    rig.advance(2s);
    EXPECT_GE(rig.status().render.scene_frames, pictures + 9U) << "of 10 in two seconds";
    EXPECT_GT(difference(rig.picture(), plain, 60, 260), 0.05) << "the other device works";
    const auto visitor = parse_json(read_text_file(rig.folder / "status.json").value())["visitor"];
    EXPECT_EQ(visitor["devices"][0]["up"], false);
    EXPECT_THAT(visitor["devices"][0]["problem"].get<std::string>(), HasSubstr("hung: its driver has not answered"));
    EXPECT_EQ(visitor["devices"][1]["up"], true);
    trap.let_go();
    rig.devices.input.devices[hangs].*where = [] {};
    rig.advance(2s);
    rig.status();
    const auto after = parse_json(read_text_file(rig.folder / "status.json").value())["visitor"];
    EXPECT_EQ(after["devices"][0]["up"], true) << after["devices"][0]["problem"];
  }
}

double resident_megabytes() {
  std::ifstream file("/proc/self/statm");
  long total = 0, resident = 0;
  file >> total >> resident;
  return static_cast<double>(resident) * static_cast<double>(::sysconf(_SC_PAGESIZE)) / 1e6;
}

// A child's afternoon: eras, views, languages, stories, wipes, and pauses in which the screen goes idle.
TEST(Visitor, TenThousandRandomInputsLeaveStateMemoryAndPictureSane) {
  auto options = with_three_eras("visitor-child");
  ASSERT_TRUE(write_text_file(test_folder("appliance-visitor-child") / "content.toml",
                              "languages = [\"en\", \"de\"]\n[[story]]\nname = \"gate\"\nplace_m = [0, 3, 0]\n"
                              "title = { en = \"The gate\", de = \"Das Tor\" }\n"
                              "text = { en = \"Built in 730.\", de = \"Erbaut 730.\" }\n"));
  options.first_config = "content = \"content.toml\"\n";
  Rig rig(std::move(options));
  auto& panel = rig.devices.input.devices[kPanel];
  panel.axes[ABS_X].maximum = 1000;
  rig.advance(12s);
  const auto plain = rig.picture();
  std::mt19937 random(11);
  constexpr int kKeys[] = {KEY_SPACE, KEY_L, KEY_P, KEY_S, KEY_V, KEY_E};
  std::array<bool, std::size(kKeys)> down{};
  bool finger = false;
  std::set<std::string> eras;
  std::set<BuildingView> views;
  double settled = 0.0;
  constexpr int kHalfOfThem = 4800;  // of both rhythms below
  for (int i = 0; i < 10'000; ++i) {
    const auto what = random() % 10;
    if (what < 7) {
      // An era is a model made ready anew, a tenth of a second of work: pressed a tenth as often as the others.
      const auto key = random() % 51 * (std::size(kKeys) - 1) / 50;
      panel.key(kKeys[key], down[key] = !down[key]);
    } else if (what == 7) {
      panel.send(EV_KEY, BTN_TOUCH, (finger = !finger) ? 1 : 0);
    } else if (what == 8) {
      panel.send(EV_ABS, ABS_X, static_cast<int>(random() % 1200) - 100);
    } else {
      panel.send(EV_REL, REL_DIAL, static_cast<int>(random() % 41) - 20);
    }
    panel.report();
    if (i % 16 == 0) rig.advance(2 * Rig::kTick);
    if (i % 400 == 0) rig.advance(3s);
    if (i == kHalfOfThem) rig.advance(50s, 100ms);
    if (i % 16 != 0) continue;
    ASSERT_EQ(rig.shown(), Shown::live) << "after input " << i;
    eras.insert(rig.status().era);
    views.insert(rig.appliance->render().shown_view());
    if (i != kHalfOfThem) continue;
    EXPECT_TRUE(rig.status().render.visitor->idle);
    settled = resident_megabytes();
  }
  EXPECT_EQ(eras.size(), 3U) << testing::PrintToString(eras);
  EXPECT_GE(views.size(), 4U);
  rig.advance(55s, 100ms);
  EXPECT_TRUE(rig.status().render.visitor->idle);
  ASSERT_GT(settled, 0.0);
  EXPECT_LT(resident_megabytes() - settled, 40.0) << "more than after half of them";
  EXPECT_EQ(rig.status().era, "temple");
  rig.advance(6s);
  EXPECT_LT(difference(rig.picture(), plain, 0, plain.width()), 0.05) << "as before the first of them";
  EXPECT_EQ(rig.status().reload->era_problem, "");
}

// 10^5 events a second of all kinds.
TEST(Visitor, Row49AHostileDeviceStopsNoPicture) {
  VisitedKiosk kiosk("hostile");
  kiosk.panel().keeps = 512;
  const auto pictures = kiosk.rig->status().render.scene_frames;
  std::mt19937 random(3);
  for (int i = 0; i < 250; ++i) {
    for (int event = 0; event < 2000; ++event)
      kiosk.panel().send(static_cast<int>(random() % 32U), static_cast<int>(random() % 768U),
                         static_cast<int>(random()));
    const auto before = kiosk.panel().read;
    kiosk.rig->advance(Rig::kTick);
    EXPECT_LE(kiosk.panel().read - before, 2 * kMostInputEvents);
  }
  EXPECT_EQ(kiosk.rig->shown(), Shown::live);
  EXPECT_GE(kiosk.rig->status().render.scene_frames, pictures + 20U) << "of 25 in five seconds";
  kiosk.panel().plugged = false;
  kiosk.rig->advance(50s);
  EXPECT_TRUE(kiosk.rig->status().render.visitor->idle);
}

}  // namespace
}  // namespace kasumi
