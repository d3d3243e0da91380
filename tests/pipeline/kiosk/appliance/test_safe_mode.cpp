// Safe mode, and what proves that a start has come well.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <map>
#include <new>

#include <sys/stat.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "pipeline/kiosk/start/kept_content.hpp"
#include "tests/pipeline/kiosk/appliance/kiosk_process.hpp"
#include "tests/pipeline/kiosk/appliance/safe_rig.hpp"
#include "tests/pipeline/recorded.hpp"

namespace kasumi {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(SafeMode, Row34ShowsTheStillWithoutCamerasAndTellsTheOperatorWhy) {
  SafeRig rig("shows");
  rig.start();
  rig.advance(3s);
  ASSERT_TRUE(rig.corner());
  EXPECT_EQ(*rig.corner(), (Rgb8{200, 40, 160}));
  EXPECT_EQ(rig.notifier.readies, 1);
  EXPECT_GE(rig.notifier.alives, 2);
  const auto status = rig.status();
  EXPECT_EQ(status["shown"], "still");
  EXPECT_THAT(status["reason"].get<std::string>(), HasSubstr("safe mode"));
  EXPECT_EQ(status["start"]["safe_mode"], true);
  EXPECT_EQ(status["start"]["failed_boots"], 3);
  EXPECT_THAT(status["start"]["why"].dump(), HasSubstr("opening cameras and display"));
  EXPECT_EQ(status["scene_camera"]["up"], false);
  EXPECT_EQ(status["scene_camera"]["opened"], 0);
  EXPECT_THAT(rig.notifier.lines.front(), HasSubstr("opening cameras and display"));
}

TEST(SafeMode, Row34TheWordsAreOnThePicture) {
  SafeRig with("words"), without("no-words");
  replace_in(without.config, "language = \"en\"", "show_faults = false");
  const auto picture = [](SafeRig& rig) {
    rig.start();
    rig.advance(1s);
    return read_picture(*rig.safe->display()).value();
  };
  const auto a = picture(with), b = picture(without);
  int different = 0;
  for (int y = 0; y < a.height() / 2; ++y)
    for (int x = 0; x < a.width(); ++x) different += a.at(x, y) != b.at(x, y);
  EXPECT_GT(different, 500) << "the message at the top";
}

// Whatever is wrong with the configuration, something is shown.
TEST(SafeMode, Row34NoConfigurationIsTooBroken) {
  SafeRig rig("broken");
  replace_in(rig.config, "latitude_deg", "latitude_degrees");
  std::filesystem::remove(rig.folder / "temple.glb");
  ASSERT_TRUE(write_text_file(rig.folder / "still.png", "not a picture"));
  rig.start();
  rig.advance(1s);
  EXPECT_EQ(rig.status()["display"]["up"], true);
  EXPECT_EQ(*rig.corner(), (Rgb8{38, 44, 52})) << "the plain background";
}

TEST(SafeMode, Row34WhereTheStillItselfIsTheCauseItIsLeftOut) {
  SafeRig rig("plain", StartMode::plain);
  rig.start();
  rig.advance(1s);
  EXPECT_EQ(*rig.corner(), (Rgb8{38, 44, 52}));
}

// The configuration as somebody else left it, in every way that its reader can come to grief.
TEST(SafeMode, Row40ACrashAHangOrAnErrorOfItsReaderIsAnAnswer) {
  SafeRig rig("reader");
  const std::map<std::string, FindConfiguration> ways{
      {"crash",
       []() -> std::filesystem::path {
         std::raise(SIGSEGV);
         return {};
       }},
      {"hang",
       []() -> std::filesystem::path {
         for (;;) ::pause();
       }},
      {"exception", []() -> std::filesystem::path { throw std::bad_alloc(); }},
      {"absent", [] { return std::filesystem::path("/nowhere/kasumi.toml"); }},
  };
  for (const auto& [way, find] : ways) {
    SCOPED_TRACE(way);
    const auto content = read_safe_content(find, StartMode::safe, 300ms);
    ASSERT_TRUE(content);
    EXPECT_TRUE(content->config.messages.plain_letters) << "words all the same";
    EXPECT_FALSE(content->still);
  }
}

// Each file that safe mode names, in every state.
TEST(SafeMode, Row40EveryFileOfItMayBeAPipeUnreadableEmptyOrTooDeep) {
  for (const char* name : {"kasumi.toml", "still.png"})
    for (const char* state : {"pipe", "unreadable", "empty", "deep", "absent"}) {
      SCOPED_TRACE(fmt::format("{} {}", name, state));
      SafeRig rig("files");
      const auto file = rig.folder / name;
      std::filesystem::remove(file);
      if (state == std::string("pipe")) {
        ASSERT_EQ(::mkfifo(file.c_str(), 0600), 0);
      }
      if (state == std::string("unreadable")) make_unreadable(file);
      if (state == std::string("empty")) {
        ASSERT_TRUE(write_text_file(file, ""));
      }
      if (state == std::string("deep")) {
        std::string deep = "a";
        for (int i = 0; i < 100'000; ++i) deep += ".a";
        ASSERT_TRUE(write_text_file(file, deep + " = 1\n"));
      }
      const auto began = std::chrono::steady_clock::now();
      rig.start();
      rig.advance(1s);
      EXPECT_LT(std::chrono::steady_clock::now() - began, 10s * kSlowness);
      EXPECT_EQ(rig.notifier.readies, 1);
      EXPECT_TRUE(rig.corner());
    }
}

TEST(SafeMode, Row40ThePlainModeReadsNothing) {
  SafeRig rig("plain-reads-nothing", StartMode::plain);
  bool asked = false;
  const auto content = read_safe_content(
      [&] {
        asked = true;
        return rig.config;
      },
      StartMode::plain);
  EXPECT_FALSE(asked);
  EXPECT_TRUE(content->config.messages.plain_letters);
  rig.start();
  rig.advance(1s);
  const auto picture = read_picture(*rig.safe->display()).value();
  int letters = 0;
  for (int y = 0; y < picture.height() / 2; ++y)
    for (int x = 0; x < picture.width(); ++x) letters += picture.at(x, y).r > 200;
  EXPECT_GT(letters, 200) << "words in its own letters";
}

TEST(SafeMode, ADisplayComesAndGoes) {
  SafeRig rig("display");
  rig.devices.display.unplugged = true;
  rig.start();
  rig.advance(30s);
  EXPECT_EQ(rig.notifier.readies, 0);
  EXPECT_GT(rig.notifier.extensions, 1);
  rig.devices.display.unplugged = false;
  rig.advance(2s);
  EXPECT_EQ(rig.notifier.readies, 1);
  rig.devices.display.stuck = rig.devices.display.opening_mends = true;
  rig.advance(4s);
  EXPECT_EQ(rig.status()["display"]["resets"], 1);
  EXPECT_TRUE(rig.corner());
}

TEST(SafeMode, ItEndsAfterAnHourForATrial) {
  SafeRig rig("hour");
  rig.start();
  rig.clock.advance(59min);
  EXPECT_FALSE(rig.safe->is_over());
  rig.clock.advance(2min);
  EXPECT_TRUE(rig.safe->is_over());
  rig.starts->ended();
  EXPECT_EQ(StartLog({rig.folder / "state", {}}, "now", 4000.0).mode(), StartMode::whole);
}

// A rig of the whole appliance that is told of its starts.
struct ProvenRig : Rig {
  explicit ProvenRig(const std::string& name) : Rig({.name = name, .observe_every = kSeldom}) {
    kept = folder / "state/last-good";
    starts = std::make_unique<StartLog>(ServiceFolders{folder / "state", folder}, "now", 15.0);
    appliance = std::make_unique<Appliance>(
        config, read_content(config).value(), ApplianceServices{devices, clock, time, notifier, {starts.get(), kept}},
        StatusOutputs{folder / "status.json", false, 10s, starts.get()}, observing_seldom());
  }
  // In long steps, with pictures in each.
  void pass(Duration by) {
    for (const auto end = clock.now() + by; clock.now() < end;) {
      advance(5s, 5s);
      appliance->proving().step();
    }
  }
  std::filesystem::path kept;
  std::unique_ptr<StartLog> starts;
};

TEST(Proving, Row32TenMinutesOfPicturesKeepTheContentAndForgiveTheStarts) {
  ProvenRig rig("proven");
  rig.pass(9min);
  EXPECT_TRUE(rig.starts->record().shown);
  EXPECT_FALSE(rig.starts->record().well);
  EXPECT_FALSE(std::filesystem::exists(rig.kept / "kept.json"));
  rig.pass(2min);
  EXPECT_TRUE(rig.starts->record().well);
  EXPECT_TRUE(std::filesystem::exists(rig.kept / "kept.json"));
  EXPECT_TRUE(read_kept_content(rig.config, rig.kept, {}));
}

TEST(Proving, Row32AStillPictureProvesTheStartButNotTheContent) {
  ProvenRig rig("proven-still");
  rig.devices.scene.unplugged = true;
  rig.pass(11min);
  EXPECT_TRUE(rig.starts->record().well);
  EXPECT_FALSE(std::filesystem::exists(rig.kept / "kept.json"));
}

TEST(Proving, Row34AHangingLoopProvesNothing) {
  ProvenRig rig("proves-nothing");
  rig.render_hangs = true;
  rig.pass(11min);
  EXPECT_FALSE(rig.starts->record().shown);
  EXPECT_FALSE(rig.starts->record().well);
}

}  // namespace
}  // namespace kasumi
