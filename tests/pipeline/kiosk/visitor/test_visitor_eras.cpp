// A visitor chooses the time in which the building stands.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "base/outside/json_text.hpp"
#include "tests/pipeline/kiosk/appliance/rig.hpp"
#include "tests/pipeline/kiosk/visitor/visited_kiosk.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

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
    return parse_json(read_text_file(rig.folder / "status.json").value())["content"];
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

}  // namespace
}  // namespace kasumi
