// A television over CEC: woken before opening, asleep after closing, and none that does not answer costs anything.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/kiosk/loop/television_switch.hpp"
#include "tests/pipeline/machine/fake_television.hpp"

namespace kasumi {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class OnlyATelevision final : public Devices {
 public:
  CameraOpening camera(CameraRole, const CameraOptions&) override { return {}; }
  Result<std::unique_ptr<Display>> open_display(const DisplayOptions&) override {
    return fail(FaultKind::unsupported, "none");
  }
  std::unique_ptr<DisplayWatch> watch_displays() override { return nullptr; }
  Result<std::unique_ptr<CecDevice>> open_television(const std::filesystem::path& adapter) override {
    asked_for = adapter.string();
    return open_fake_television(television);
  }
  Result<std::unique_ptr<InputDevice>> open_input(const std::filesystem::path&) override {
    return fail(FaultKind::disconnected, "no input device");
  }
  void serve(std::shared_ptr<InputLink>) override {}
  FakeTelevision television;
  std::string asked_for;
};

struct Bench {
  ManualClock clock{Utc{}};
  OnlyATelevision devices;
  TelevisionSwitch controls{"/dev/cec0", devices, clock};
  FakeTelevision& tv = devices.television;
  void pass(Duration time) {
    for (Duration passed{}; passed < time; passed += 500ms) {
      controls.step();
      clock.advance(500ms);
    }
  }
};

TEST(Television, IsWokenShowsOurInputAndIsSentToSleep) {
  Bench bench;
  bench.pass(60s);
  EXPECT_THAT(bench.tv.heard, IsEmpty()) << "nothing was asked of it";
  bench.controls.want(true);
  bench.pass(60s);
  EXPECT_TRUE(bench.tv.on);
  EXPECT_EQ(bench.tv.active, 0x2000);
  EXPECT_THAT(bench.tv.heard, ElementsAre("40:04", "4f:82:20:00", "40:8f"));
  EXPECT_EQ(bench.controls.status().power, TelevisionPower::on);
  EXPECT_EQ(bench.devices.asked_for, "/dev/cec0");
  EXPECT_EQ(bench.tv.claimed.primary_device_type[0], CEC_OP_PRIM_DEVTYPE_PLAYBACK);
  EXPECT_STREQ(bench.tv.claimed.osd_name, "Kasumi");

  bench.tv.heard.clear();
  bench.controls.want(false);
  bench.pass(60s);
  EXPECT_FALSE(bench.tv.on);
  EXPECT_THAT(bench.tv.heard, ElementsAre("40:36", "40:8f"));
  EXPECT_EQ(bench.controls.status().answers, true);
}

TEST(Television, WhoeverPressesTheRemoteControlIsNotFought) {
  Bench bench;
  bench.controls.want(true);
  bench.pass(60s);
  bench.tv.on = false;
  bench.controls.want(true);
  bench.pass(1h);
  EXPECT_FALSE(bench.tv.on);
}

TEST(Television, OneThatHasLetTheLineGoIsWokenWithoutAnAddress) {
  Bench bench;
  bench.tv.hot_plug = false;
  bench.tv.says_power = false;
  bench.controls.want(true);
  bench.pass(60s);
  EXPECT_TRUE(bench.tv.on);
  EXPECT_EQ(bench.tv.heard.front(), "f0:04");
  EXPECT_EQ(bench.controls.status().answers, true);
  EXPECT_EQ(bench.controls.status().power, TelevisionPower::unknown);
}

TEST(Television, OneThatDoesNotObeyIsToldThreeTimes) {
  Bench bench;
  bench.tv.obeys = false;
  bench.controls.want(true);
  bench.pass(1h);
  EXPECT_EQ(std::ranges::count(bench.tv.heard, "40:04"), 3);
  EXPECT_THAT(bench.controls.status().problem, HasSubstr("stays standby"));
}

TEST(Television, OneThatDoesNotAnswerIsLeftAloneUntilTheNextChange) {
  Bench bench;
  bench.tv.there = false;
  bench.controls.want(true);
  testing::internal::CaptureStderr();
  bench.pass(10h);
  EXPECT_EQ(bench.tv.opened, 4);
  EXPECT_EQ(bench.controls.status().answers, false);
  EXPECT_THAT(bench.controls.status().problem, HasSubstr("no television answers"));
  bench.tv.there = true;
  bench.controls.want(false);
  bench.pass(60s);
  EXPECT_EQ(bench.controls.status().answers, true);
  EXPECT_EQ(bench.controls.status().problem, "");
  testing::internal::GetCapturedStderr();
}

TEST(Television, WithoutAnAdapterNothingFails) {
  Bench bench;
  bench.tv.adapter = false;
  bench.controls.want(true);
  bench.pass(1h);
  EXPECT_THAT(bench.controls.status().problem, HasSubstr("/dev/cec0"));
  bench.controls.use("");
  bench.controls.want(false);
  bench.pass(1h);
  EXPECT_EQ(bench.tv.opened, 0);
  EXPECT_EQ(open_cec_device("/nonexistent/cec7").error().kind, FaultKind::disconnected);
}

TEST(Television, ADeviceThatIsNoAdapterIsRefused) {
  const auto null = open_cec_device("/dev/null");
  ASSERT_TRUE(null);
  EXPECT_FALSE(wake_television(**null));
  EXPECT_FALSE(send_television_to_sleep(**null));
  EXPECT_FALSE(ask_television(**null));
}

}  // namespace
}  // namespace kasumi
