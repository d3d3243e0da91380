// A visitor's hand on the appliance: what the glass shows.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "capture/codec/dimmed_picture.hpp"
#include "pipeline/show/stage/shown_story.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/kiosk/appliance/rig.hpp"
#include "tests/pipeline/kiosk/visitor/visited_kiosk.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

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
  VisitedKiosk kiosk("wipe");
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
  VisitedKiosk kiosk("language");
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

// In large print a story may fill the screen's height: also where the labels of a wipe are to be read.
TEST(Visitor, AStoryLeavesTheLabelsFree) {
  const auto folder = test_folder("appliance-visitor-labels");
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  std::string text;
  for (int i = 0; i < 19; ++i) text += "five roofs ";
  ASSERT_TRUE(write_text_file(folder / "content.toml",
                              "languages = [\"en\"]\n[[story]]\nname = \"roofs\"\nplace_m = [0, 3, 0]\n"
                              "title = { en = \"Roofs\" }\ntext = { en = \"" +
                                  text + "\" }\n"));
  Rig rig({.name = "visitor-labels",
           .recording = source_folder() / "fixtures/demo",
           .more_config = kHand,
           .first_config = "content = \"content.toml\"\n",
           .utc = std::chrono::sys_days{std::chrono::October / 20 / 2026} + 6h + 10min,
           .observe_every = 30s,
           .keep_folder = true});
  auto& panel = rig.devices.input.devices[kPanel];
  const auto tap = [&](int code) {
    for (const bool down : {true, false}) {
      panel.key(code, down);
      rig.advance(60ms);
    }
  };
  rig.advance(4s);
  ASSERT_EQ(rig.shown(), Shown::live);
  tap(KEY_P);
  panel.key(KEY_SPACE, true);
  rig.advance(4s);  // what a key did is said no longer
  const auto labels = rig.picture();
  tap(KEY_S);
  rig.advance(4s);
  const auto told = rig.picture();
  int changed = 0, covered = 0;
  for (int y = 0; y < told.height(); ++y)
    for (int x = 0; x < told.width(); ++x)
      if (std::abs(told.at(x, y).g - labels.at(x, y).g) > 20) ++(y < 620 ? changed : covered);
  EXPECT_GT(changed, 50'000) << "the panel";
  EXPECT_LT(covered, 100) << "of the rows in which the label is";
  panel.key(KEY_SPACE, false);
  rig.advance(4s);
  const auto let_go = rig.picture();
  int moved = 0;
  for (int y = 0; y < 620; ++y)
    for (int x = 0; x < 400; ++x) moved += std::abs(told.at(x, y).g - let_go.at(x, y).g) > 20 ? 1 : 0;
  EXPECT_LT(moved, 100) << "while it is read it stays where it is";
}

double mean_green(const Image<Rgb8>& picture, int from, int to) {
  double sum = 0.0;
  for (int y = 20; y < 60; ++y)
    for (int x = from; x < to; ++x) sum += picture.at(x, y).g;
  return sum / (40.0 * (to - from));
}

TEST(Visitor, TheBuildingIsSeenAloneInClearAirAndAtOtherHours) {
  VisitedKiosk kiosk("views");
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
  VisitedKiosk plain("no-hints"), kiosk("hints", "hints = [\"then_and_now\", \"era\", \"language\"]\n");
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

}  // namespace
}  // namespace kasumi
