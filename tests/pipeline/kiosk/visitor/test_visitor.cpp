// A visitor's hand on the appliance: events of fake devices in, pictures of the glass out.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <random>
#include <set>

#include <unistd.h>

#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "capture/codec/dimmed_picture.hpp"
#include "pipeline/kiosk/visitor/visitor_presses.hpp"
#include "pipeline/show/stage/shown_story.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/kiosk/appliance/rig.hpp"
#include "tests/pipeline/recorded.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

const std::filesystem::path kPanel = "/dev/input/by-id/usb-Panel-event-kbd";
constexpr const char* kHand =
    "\n[visitor]\ndevices = [\"/dev/input/by-id/usb-Panel-event-kbd\"]\nthen_and_now = [\"KEY_SPACE\"]\n"
    "era = [\"KEY_E\"]\nlanguage = [\"KEY_L\"]\nlarge_print = [\"KEY_P\"]\nstory = [\"KEY_S\"]\nview = [\"KEY_V\"]\n";

struct Kiosk {
  explicit Kiosk(const std::string& name, const std::string& more = {}) {
    rig = std::make_unique<Rig>(RigOptions{.name = name, .more_config = kHand + more});
    plug();
    rig->advance(12s);
    EXPECT_EQ(rig->shown(), Shown::live);
  }
  void plug() {
    auto& is = rig->devices.input.devices[kPanel];
    is.plugged = true;
    is.axes[ABS_X].maximum = 1000;
  }
  FakeInputDevice& panel() { return rig->devices.input.devices[kPanel]; }
  void tap(int code) {
    panel().key(code, true);
    rig->advance(60ms);
    panel().key(code, false);
    rig->advance(60ms);
  }
  void touch(int place) {
    panel().send(EV_KEY, BTN_TOUCH, 1);
    panel().send(EV_ABS, ABS_X, place);
    panel().report();
    rig->advance(400ms);
  }
  void let_go() {
    panel().send(EV_KEY, BTN_TOUCH, 0);
    panel().report();
    rig->advance(40ms);
  }
  nlohmann::json status() {
    rig->status();
    return nlohmann::json::parse(read_text_file(rig->folder / "status.json").value());
  }
  std::unique_ptr<Rig> rig;
};

// Below the frame's number and above the labels.
double difference(const Image<Rgb8>& a, const Image<Rgb8>& b, int from, int to) {
  double sum = 0.0;
  for (int y = 20; y < 120; ++y)
    for (int x = from; x < to; ++x) sum += std::abs(a.at(x, y).g - b.at(x, y).g);
  return sum / (100.0 * (to - from));
}

TEST(Visitor, WithoutTheTableNothingIsOpenedAndTheGlassIsTheSame) {
  Rig plain({.name = "no-visitor"});
  plain.devices.input.devices[kPanel] = {};
  plain.devices.input.devices[kPanel].key(KEY_SPACE, true);
  Rig idle({.name = "idle-visitor", .more_config = kHand});
  idle.devices.input.devices[kPanel] = {};
  for (auto* rig : {&plain, &idle}) rig->advance(12s);
  EXPECT_EQ(plain.devices.input.devices[kPanel].opened, 0);
  EXPECT_EQ(idle.devices.input.devices[kPanel].opened, 1);
  plain.status();
  EXPECT_EQ(read_text_file(plain.folder / "status.json").value().find("visitor"), std::string::npos);
  const auto a = plain.picture(), b = idle.picture();
  ASSERT_EQ(frame_number(a), frame_number(b));
  EXPECT_EQ(a.elements(), b.elements()) << "an idle visitor's picture is the plain one";
}

TEST(Visitor, AFingerWipesTheBuildingAwayAndItComesBack) {
  Kiosk kiosk("wipe");
  const auto plain = kiosk.rig->picture();
  kiosk.panel().key(KEY_SPACE, true);
  kiosk.rig->advance(1s);
  const auto bare = kiosk.rig->picture();
  EXPECT_GT(difference(plain, bare, 60, 260), 0.05) << "the building is gone";
  kiosk.panel().key(KEY_SPACE, false);
  kiosk.rig->advance(2s);
  EXPECT_LT(difference(kiosk.rig->picture(), plain, 60, 260), 0.02) << "and is back";
  kiosk.touch(500);
  const auto wiped = kiosk.rig->picture();
  EXPECT_LT(difference(wiped, bare, 20, 155), 0.02);
  EXPECT_LT(difference(wiped, plain, 165, 300), 0.02);
  kiosk.let_go();
  kiosk.rig->advance(2s);
  EXPECT_LT(difference(kiosk.rig->picture(), plain, 20, 300), 0.02);
  EXPECT_EQ(kiosk.status()["visitor"]["presses"], 2);
}

TEST(Visitor, AnotherVisitorFindsTheLanguageOfTheKiosk) {
  Kiosk kiosk("language");
  const auto before = kiosk.rig->picture();
  kiosk.tap(KEY_L);
  kiosk.rig->advance(200ms);
  EXPECT_NE(kiosk.rig->picture().elements(), before.elements()) << "\"Deutsch\"";
  kiosk.rig->devices.scene.unplugged = true;
  kiosk.rig->advance(10s);
  const auto german = kiosk.rig->picture();
  kiosk.rig->advance(40s);
  const auto english = kiosk.rig->picture();
  EXPECT_NE(german.elements(), english.elements()) << "the message is in the first visitor's language no longer";
  kiosk.tap(KEY_L);
  kiosk.rig->advance(4s);
  EXPECT_EQ(kiosk.rig->picture().elements(), german.elements());
  kiosk.tap(KEY_P);
  kiosk.rig->advance(4s);
  EXPECT_NE(kiosk.rig->picture().elements(), german.elements()) << "large print";
}

// White letters of the note at the top.
int letters_at_the_top(const Image<Rgb8>& picture) {
  int count = 0;
  for (int y = 2; y < 26; ++y)
    for (int x = 100; x < 220; ++x) count += picture.at(x, y).g > 215 ? 1 : 0;
  return count;
}

TEST(Visitor, AnEraIsChosenAndTheOneOfTheDayComesBack) {
  const auto folder = test_folder("appliance-visitor-era");
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  std::filesystem::copy_file(source_folder() / "fixtures/pagoda.glb", folder / "pagoda.glb");
  RigOptions options{.name = "visitor-era",
                     .more_config = std::string(kHand) +
                                    "[opening]\ntime_zone = \"UTC\"\n[[era]]\nname = \"temple\"\n"
                                    "hours = \"00:00-12:00\"\n[[era]]\nname = \"pagoda\"\nhours = \"12:00-24:00\"\n"
                                    "model = \"pagoda.glb\"\n"};
  options.keep_folder = true;
  Rig rig(options);
  rig.devices.input.devices[kPanel] = {};
  rig.advance(12s);
  const auto era = [&] { return rig.status().era; };
  EXPECT_EQ(era(), "temple");
  rig.devices.input.devices[kPanel].key(KEY_E, true);
  EXPECT_TRUE(rig.advance_until([&] { return era() == "pagoda"; }, 20s));
  EXPECT_EQ(rig.shown(), Shown::live);
  rig.advance(4s);
  const int named = letters_at_the_top(rig.picture());
  rig.advance(6s);
  EXPECT_GT(named, letters_at_the_top(rig.picture()) + 20) << "its name, when it is there";
  EXPECT_TRUE(rig.advance_until([&] { return era() == "temple"; }, 60s)) << "without a hand for 45 s";
}

// Two of the day, and one for visitors alone.
constexpr const char* kThreeEras =
    "[opening]\ntime_zone = \"UTC\"\n[[era]]\nname = \"temple\"\nhours = \"00:00-24:00\"\n"
    "[[era]]\nname = \"pagoda\"\nvisitors_only = true\nmodel = \"pagoda.glb\"\n"
    "[[era]]\nname = \"gate\"\nvisitors_only = true\nmodel = \"pagoda.glb\"\n";

RigOptions with_three_eras(const std::string& name) {
  const auto folder = test_folder("appliance-" + name);
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  std::filesystem::copy_file(source_folder() / "fixtures/pagoda.glb", folder / "pagoda.glb");
  RigOptions options{.name = name, .more_config = std::string(kHand) + kThreeEras};
  options.keep_folder = true;
  return options;
}

// How much of each building a picture holds, by least squares over the pixels that tell them apart.
class Blends {
 public:
  Blends(const Image<Rgb8>& bare, const Image<Rgb8>& before, const Image<Rgb8>& after) {
    for (int y = 30; y < 150; ++y)  // below the note
      for (int x = 0; x < bare.width(); ++x) {
        const double a = before.at(x, y).g - bare.at(x, y).g, b = after.at(x, y).g - bare.at(x, y).g;
        if (std::abs(a) > 8.0 || std::abs(b) > 8.0) pixels_.push_back({x, y, 1.0 * bare.at(x, y).g, a, b});
      }
  }
  std::size_t pixels() const { return pixels_.size(); }
  std::pair<double, double> of(const Image<Rgb8>& picture) const {
    double aa = 0.0, ab = 0.0, bb = 0.0, ap = 0.0, bp = 0.0;
    for (const auto& [x, y, bare, a, b] : pixels_) {
      const double p = picture.at(x, y).g - bare;
      aa += a * a, ab += a * b, bb += b * b, ap += a * p, bp += b * p;
    }
    const double whole = aa * bb - ab * ab;
    return {(ap * bb - bp * ab) / whole, (bp * aa - ap * ab) / whole};
  }

 private:
  struct Pixel {
    int x, y;
    double bare, a, b;
  };
  std::vector<Pixel> pixels_;
};

TEST(Visitor, OneEraFadesIntoTheOtherAndNoPictureIsWithoutABuilding) {
  Rig rig(with_three_eras("visitor-fade"));
  auto& panel = rig.devices.input.devices[kPanel];
  rig.advance(12s);
  panel.key(KEY_SPACE, true);
  rig.advance(1s);
  const auto bare = rig.picture();
  panel.key(KEY_SPACE, false);
  rig.advance(4s);
  const auto before = rig.picture();
  panel.key(KEY_E, true);
  std::vector<Image<Rgb8>> pictures;
  std::vector<Instant> at;
  auto shown = rig.appliance->render().status().pictures;
  const auto look = [&] {
    if (rig.appliance->render().status().pictures == shown) return;
    shown = rig.appliance->render().status().pictures;
    pictures.push_back(rig.picture());
    at.push_back(rig.clock.now());
    EXPECT_EQ(rig.shown(), Shown::live);
    EXPECT_TRUE(rig.appliance->render().status().building_drawn);
  };
  ASSERT_TRUE(rig.advance_until([&] { return look(), rig.status().era == "pagoda"; }, 20s));
  (void)rig.advance_until([&] { return look(), false; }, 3s);
  const Blends blends(bare, before, rig.picture());
  ASSERT_GT(blends.pixels(), 200U);
  int between = 0, without = 0;
  std::optional<Instant> began, ended;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const auto [old_one, new_one] = blends.of(pictures[i]);
    without += old_one + new_one < 0.85 ? 1 : 0;
    EXPECT_LT(old_one + new_one, 1.15) << "picture " << i;
    between += new_one > 0.1 && new_one < 0.9 ? 1 : 0;
    if (new_one < 0.03) began = at[i];
    if (!ended && new_one > 0.97) ended = at[i];
  }
  EXPECT_EQ(without, 0) << "of " << pictures.size() << " pictures";
  EXPECT_GE(between, 5);
  ASSERT_TRUE(began && ended);
  EXPECT_GT(*ended, *began);
  EXPECT_LE(*ended - *began, 500ms);
}

TEST(Visitor, AnEraThatCannotBeShownKeepsNoOtherAway) {
  auto options = with_three_eras("visitor-refused");
  bool little = false;
  options.probes.memory_left = [&] { return little ? 1'000'000u : 8'000'000'000u; };
  Rig rig(std::move(options));
  const auto press = [&] {
    auto& panel = rig.devices.input.devices[kPanel];
    panel.key(KEY_E, true);
    rig.advance(60ms);
    panel.key(KEY_E, false);
    rig.advance(60ms);
  };
  const auto content = [&] {
    rig.status();
    return nlohmann::json::parse(read_text_file(rig.folder / "status.json").value())["content"];
  };
  rig.devices.input.devices[kPanel] = {};
  rig.advance(12s);
  little = true;
  press();
  rig.advance(2s);
  EXPECT_THAT(content()["era_problem"].get<std::string>(), HasSubstr("\"pagoda\" cannot be shown"));
  const auto said = rig.picture();
  rig.advance(10s);
  double plate = 0.0;
  for (int x = 100; x < 220; ++x) plate += std::abs(said.at(x, 14).g - rig.picture().at(x, 14).g) / 120.0;
  EXPECT_GT(plate, 20.0) << "it is said, and not for ever";
  EXPECT_EQ(rig.shown(), Shown::live);
  little = false;
  press();
  EXPECT_TRUE(rig.advance_until([&] { return rig.status().era == "gate"; }, 20s)) << "the next one is not refused";
  EXPECT_FALSE(content()["era_problem"].is_null()) << "the operator still hears of the other";
  EXPECT_TRUE(rig.advance_until([&] { return rig.status().era == "temple"; }, 60s)) << "without a hand for 45 s";
}

// Pressed on while the first is being prepared.
TEST(Visitor, AnEraThatIsPassedOverIsNeverShown) {
  Rig rig(with_three_eras("visitor-passed-over"));
  auto& panel = rig.devices.input.devices[kPanel];
  rig.advance(12s);
  for (const bool down : {true, false, true}) {
    panel.key(KEY_E, down);
    rig.advance(40ms);
  }
  EXPECT_TRUE(rig.advance_until(
      [&] {
        EXPECT_NE(rig.status().era, "pagoda");
        return rig.status().era == "gate";
      },
      20s));
}

TEST(Visitor, WhatIsSaidOfAnEraThatDoesNotComeIsInTheVisitorsLanguage) {
  ManualClock clock(std::chrono::sys_days{std::chrono::June / 21 / 2026} + 3h);
  BenchDevices devices(clock);
  auto& panel = devices.input.devices[kPanel];
  Content content;
  for (const char* name : {"temple", "pagoda"}) {
    content.config.eras.emplace_back();
    content.config.eras.back().name = name;
    content.config.eras.back().visitors_only = name == std::string("pagoda");
  }
  content.eras = std::make_shared<const std::vector<EraContent>>(2);
  VisitorContent texts;
  texts.languages = {"en", "de"};
  texts.eras.push_back({"pagoda", {{"en", "Around 1100"}, {"de", "Um 1100"}}, {}});
  content.visitor = std::make_shared<const VisitorContent>(texts);
  auto& visitor = content.config.visitor.emplace();
  visitor.devices = {kPanel};
  visitor.keys[static_cast<std::size_t>(HandKey::era)] = {KEY_E};
  visitor.keys[static_cast<std::size_t>(HandKey::language)] = {KEY_L};
  VisitorDesk desk(devices, clock, [] {});
  desk.use(content);
  const auto step = [&](Duration by, std::size_t refused = kNoEra) {
    for (const auto until = clock.now() + by; clock.now() < until; clock.advance(100ms)) {
      devices.turn_inputs();
      desk.step(refused);
    }
    return desk.note();
  };
  step(1s);
  panel.key(KEY_E, true);
  EXPECT_EQ(step(1s), "Around 1100 ...");
  EXPECT_EQ(step(18s), "Around 1100 ...");
  EXPECT_EQ(step(2s), "Around 1100\nThis time cannot be shown just now.");
  panel.key(KEY_L, true);
  EXPECT_EQ(step(1s), "Um 1100\nDiese Zeit kann gerade nicht gezeigt werden.");
  EXPECT_EQ(step(10s), "") << "and not for ever";
  for (const bool down : {false, true, false, true}) {  // the day's own, and this one again
    panel.key(KEY_E, down);
    step(100ms, 1);
  }
  EXPECT_EQ(step(100ms, 1), "Um 1100\nDiese Zeit kann gerade nicht gezeigt werden.") << "at once, once it is refused";
  EXPECT_EQ(step(60s, 1), "") << "the next visitor reads nothing of it";
}

TEST(Visitor, AStoryIsReadBesideTheBuilding) {
  const auto folder = test_folder("appliance-visitor-story");
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  ASSERT_TRUE(write_text_file(folder / "content.toml",
                              "languages = [\"en\", \"de\"]\n[[story]]\nname = \"gate\"\nplace_m = [0, 3, 0]\n"
                              "title = { en = \"The gate\", de = \"Das Tor\" }\n"
                              "text = { en = \"Built in 730.\", de = \"Erbaut 730.\" }\n"));
  Rig rig({.name = "visitor-story",
           .more_config = kHand,
           .first_config = "content = \"content.toml\"\n",
           .keep_folder = true});
  rig.devices.input.devices[kPanel] = {};
  rig.advance(12s);
  const auto tap = [&](int code) {
    for (const bool down : {true, false}) {
      rig.devices.input.devices[kPanel].key(code, down);
      rig.advance(60ms);
    }
    rig.advance(4s);  // what a key did is said no longer
  };
  const auto plain = rig.picture();
  tap(KEY_S);
  const auto english = rig.picture();
  EXPECT_NE(english.elements(), plain.elements());
  const auto content = must(read_content(rig.config));
  const auto building =
      building_on_screen((*content)->config.installation, *(*content)->model, plain.width(), plain.height());
  ASSERT_TRUE(building);
  double over = 0.0;
  for (int y = 20; y < plain.height(); ++y)
    for (int x = 0; x < plain.width(); ++x)
      if (x >= building->left && x < building->left + building->width && y >= building->top &&
          y < building->top + building->height)
        over = std::max(over, 1.0 * std::abs(plain.at(x, y).g - english.at(x, y).g));
  EXPECT_LT(over, 4.0) << "the panel covers the building";
  tap(KEY_L);
  EXPECT_NE(rig.picture().elements(), english.elements()) << "in German";
  tap(KEY_S);
  EXPECT_LT(difference(rig.picture(), plain, 0, plain.width()), 0.05) << "after the last none";
  tap(KEY_S);
  rig.advance(50s);
  EXPECT_LT(difference(rig.picture(), plain, 0, plain.width()), 0.05) << "the next visitor finds none";
}

double mean_green(const Image<Rgb8>& picture, int from, int to) {
  double sum = 0.0;
  for (int y = 20; y < 60; ++y)
    for (int x = from; x < to; ++x) sum += picture.at(x, y).g;
  return sum / (40.0 * (to - from));
}

TEST(Visitor, TheBuildingIsSeenAloneInClearAirAndAtOtherHours) {
  Kiosk kiosk("views");
  auto& rig = *kiosk.rig;
  const auto shown_view = [&] { return rig.appliance->render().shown_view(); };
  const auto plain = rig.picture();
  const auto next = [&] {
    kiosk.tap(KEY_V);
    rig.advance(500ms);
  };
  next();
  EXPECT_EQ(shown_view(), BuildingView::alone);
  const auto alone = rig.picture();
  EXPECT_NEAR(mean_green(alone, 20, 40), kDimmed * mean_green(plain, 20, 40), 3.0) << "the sky beside it is dimmed";
  next();
  EXPECT_TRUE(rig.advance_until([&] { return shown_view() == BuildingView::clear_air; }, 10s));
  rig.advance(4s);
  const auto clear = rig.picture();
  EXPECT_LT(difference(clear, plain, 20, 40), 0.5) << "the sky is as it is";
  EXPECT_GT(difference(clear, plain, 60, 260), 0.05) << "the building is in other air";
  for (const auto hour : {BuildingView::morning, BuildingView::noon, BuildingView::evening}) {
    next();
    int undimmed = 0;
    const auto is_there = [&] {
      const double sky = mean_green(rig.picture(), 20, 40);
      if (shown_view() == hour && sky > 1.2 * kDimmed * mean_green(plain, 20, 40)) ++undimmed;
      return shown_view() == hour;
    };
    EXPECT_TRUE(rig.advance_until(is_there, 10s)) << "hour " << static_cast<int>(hour);
    EXPECT_EQ(undimmed, 0) << "its layer comes with the dimming";
    rig.advance(4s);
  }
  const auto evening = rig.picture();
  EXPECT_GT(difference(evening, alone, 60, 260), 0.05) << "under another sun";
  EXPECT_TRUE(rig.advance_until([&] { return shown_view() == BuildingView::live; }, 60s)) << "without a hand for 45 s";
  rig.advance(4s);
  EXPECT_LT(difference(rig.picture(), plain, 60, 260), 0.05) << "as before: nothing of the views stays";
}

// What is waited for at most: the picture that was being drawn, and the one with the answer.
TEST(Visitor, APressIsSeenInTheSecondPictureAtTheLatest) {
  for (const std::string way : {"gpu", "processor", "planes"}) {
    RigOptions options{.name = "press-" + way, .more_config = kHand};
    options.no_leaves = true;
    options.display.planes = way == "planes";
    Rig rig(options);
    if (way != "planes") replace_in(rig.config, "kind = \"headless\"", "kind = \"headless\"\nmixing = \"" + way + "\"");
    if (way != "planes") rig.hang_up();
    if (way == "planes") rig.devices.scene.spoil = lend();
    rig.devices.input.devices[kPanel].axes[ABS_X].maximum = 1000;
    rig.advance(15s);
    ASSERT_EQ(rig.shown(), Shown::live);
    if (way == "planes") {
      EXPECT_EQ(rig.status().render.display.planes, "on");
    } else {
      EXPECT_EQ(rig.status().render.display.mixing, way);
    }
    for (const int code : {KEY_L, KEY_P, KEY_V, KEY_SPACE}) {
      const auto before = rig.picture();
      const auto pictures = rig.appliance->render().status().pictures;
      rig.devices.input.devices[kPanel].key(code, true);
      const auto changed = [&] {
        const auto now = rig.picture();
        int pixels = 0;
        for (int y = 20; y < now.height(); ++y)
          for (int x = 0; x < now.width(); ++x) pixels += std::abs(now.at(x, y).g - before.at(x, y).g) > 24 ? 1 : 0;
        return pixels > 40;
      };
      ASSERT_TRUE(rig.advance_until(changed, 2s)) << way << ", key " << code;
      const auto shown = rig.appliance->render().status().pictures - pictures;
      EXPECT_LE(shown, 2U) << way << ", key " << code;
      rig.devices.input.devices[kPanel].key(code, false);
      rig.advance(6s);
    }
  }
}

TEST(Visitor, TheGlassSaysWhatEachButtonDoes) {
  Kiosk plain("no-hints"), kiosk("hints", "hints = [\"then_and_now\", \"era\", \"language\"]\n");
  const auto without = plain.rig->picture(), with = kiosk.rig->picture();
  for (const int column : {0, 1, 2}) {
    int light = 0, changed = 0;
    for (int y = 150; y < 180; ++y)
      for (int x = 10 + column * 107; x < 97 + column * 107; ++x) {
        light += with.at(x, y).g > 200 ? 1 : 0;
        changed += std::abs(with.at(x, y).g - without.at(x, y).g) > 24 ? 1 : 0;
      }
    EXPECT_GT(light, 40) << "letters of button " << column;
    EXPECT_GT(changed, 200) << "their plate";
  }
  EXPECT_LT(difference(with, without, 20, 300), 0.05) << "above nothing changes";
  kiosk.tap(KEY_L);
  kiosk.rig->advance(4s);
  EXPECT_NE(kiosk.rig->picture().elements(), with.elements()) << "in the language that was chosen";
}

TEST(Visitor, OnlyHourAndKindArePutOnTheDisk) {
  Kiosk kiosk("presses");
  kiosk.tap(KEY_L);
  kiosk.tap(KEY_L);
  kiosk.tap(KEY_P);
  kiosk.rig->advance(2s);
  kiosk.rig->appliance->status().keep();
  const auto text = read_text_file(kiosk.rig->folder / "state" / kPressesFile).value();
  EXPECT_EQ(text, "hour_utc,then_and_now,era,language,large_print,story,view\n2026-06-21T03:00:00Z,0,0,2,1,0,0\n");
}

TEST(Visitor, Row48ADeviceThatIsUnpluggedLetsGoAndComesBack) {
  Kiosk kiosk("unplugged");
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
    const auto visitor = nlohmann::json::parse(read_text_file(rig.folder / "status.json").value())["visitor"];
    EXPECT_EQ(visitor["devices"][0]["up"], false);
    EXPECT_THAT(visitor["devices"][0]["problem"].get<std::string>(), HasSubstr("hung: its driver has not answered"));
    EXPECT_EQ(visitor["devices"][1]["up"], true);
    trap.let_go();
    rig.devices.input.devices[hangs].*where = [] {};
    rig.advance(2s);
    rig.status();
    const auto after = nlohmann::json::parse(read_text_file(rig.folder / "status.json").value())["visitor"];
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
  constexpr int kKeys[] = {KEY_SPACE, KEY_E, KEY_L, KEY_P, KEY_S, KEY_V};
  std::array<bool, std::size(kKeys)> down{};
  bool finger = false;
  std::set<std::string> eras;
  std::set<BuildingView> views;
  double settled = 0.0;
  constexpr int kHalfOfThem = 4800;  // of both rhythms below
  for (int i = 0; i < 10'000; ++i) {
    const auto what = random() % 10;
    if (what < 7) {
      const auto key = random() % std::size(kKeys);
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
  Kiosk kiosk("hostile");
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
