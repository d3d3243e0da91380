// Safe mode, and what proves that a start has come well.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "pipeline/start/kept_content.hpp"
#include "tests/pipeline/appliance/safe_rig.hpp"
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
  explicit ProvenRig(const std::string& name) : Rig({.name = name}) {
    kept = folder / "state/last-good";
    starts = std::make_unique<StartLog>(ServiceFolders{folder / "state", folder}, "now", 15.0);
    appliance = std::make_unique<Appliance>(config, read_content(config).value(),
                                            ApplianceServices{devices, clock, time, notifier, {starts.get(), kept}},
                                            StatusOptions{folder / "status.json", false, 10s, starts.get()});
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
