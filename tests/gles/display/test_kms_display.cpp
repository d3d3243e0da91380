// The KMS display on a scripted card: rows 15, 16 and 17 of docs/faults.md. Recovery times are by the manual clock.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/gles/display/kms_rig.hpp"
#include "tests/must.hpp"

namespace kasumi {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;

double ms(Duration duration) {
  return 1e3 * to_seconds(duration);
}

TEST_F(KmsRig, SetsTheModeOnceAndFlipsFromThenOn) {
  switch_on();
  for (int i = 0; i < 4; ++i) ASSERT_TRUE(show().has_value());
  EXPECT_THAT(card_.calls, ElementsAre("remember", "commit_mode wait", "commit_flip", "commit_flip", "commit_flip"));
  EXPECT_THAT(display_->description(),
              AllOf(HasSubstr("/dev/dri/card9"), HasSubstr("HDMI-A-1 64x48@60.00"), HasSubstr("atomic")));
}

TEST_F(KmsRig, UsesTheLegacyCallsWhereAtomicOnesAreMissingOrNotWanted) {
  for (const bool offered : {false, true}) {
    card_.has_atomic = offered;
    options_.atomic = !offered;
    card_.calls.clear();
    switch_on();
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(show().has_value());
    EXPECT_THAT(card_.calls, ElementsAre("remember", "set_crtc", "page_flip", "page_flip"));
    EXPECT_THAT(display_->description(), HasSubstr("legacy"));
    display_.reset();
  }
}

TEST_F(KmsRig, FallsBackToLegacyWhenTheFirstAtomicCommitIsRefused) {
  card_.atomic_mode_refusals = {std::errc::invalid_argument};
  switch_on();
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(show().has_value());
  EXPECT_THAT(card_.calls, ElementsAre("remember", "commit_mode wait", "set_crtc", "page_flip", "page_flip"));
}

TEST_F(KmsRig, ReportsWhenEachPictureReachedTheScreen) {
  switch_on();
  std::vector<Flip> flips;
  for (int i = 0; i < 5; ++i) {
    ASSERT_EQ(show().value(), static_cast<std::uint64_t>(i + 1));
    ASSERT_TRUE(display_->begin(clock_.now() + 50ms).has_value());
    for (const Flip& flip : display_->take_flips()) flips.push_back(flip);
  }
  ASSERT_EQ(flips.size(), 5u);
  for (std::size_t i = 0; i < flips.size(); ++i) {
    EXPECT_EQ(flips[i].number, i + 1);
    EXPECT_EQ(flips[i].at.time_since_epoch() % card_.refresh, 0ns) << "at a refresh";
    EXPECT_EQ(flips[i].at - flips[0].at, static_cast<int>(i) * card_.refresh);
  }
  EXPECT_EQ(display_->counts().flips, 5u);
}

TEST_F(KmsRig, RejectsImpossibleFlipTimes) {
  for (const Duration wrong : {Duration(1h), Duration(-1h)}) {
    card_.event_offset = wrong;
    see_first();
    const auto flips = display_->take_flips();
    ASSERT_EQ(flips.size(), 1u);
    EXPECT_EQ(flips[0].at, clock_.now());
    display_.reset();
  }
}

// A driver that predicts scanout reports a flip before it happens; and events may have been read late.
TEST_F(KmsRig, AcceptsPlausibleFlipTimes) {
  card_.event_offset = 1ms;
  see_first();
  EXPECT_EQ(display_->take_flips().at(0).at, clock_.now() + 1ms);
  card_.event_offset = 0ms;
  ASSERT_TRUE(display_->show().has_value());
  const Instant sent = clock_.now();
  clock_.advance(700ms);
  card_.event_offset = -600ms;
  EXPECT_EQ(display_->take_flips().at(0).at, sent + 100ms);
}

TEST_F(KmsRig, HoldsTheCamerasBufferUntilTheFlipThatReplacedIt) {
  switch_on();
  std::vector<std::weak_ptr<int>> held;
  const auto show_one = [&] {
    auto holder = std::make_shared<int>(0);
    held.push_back(holder);
    return show(std::move(holder));
  };
  const auto alive = [&] {
    std::vector<bool> answer;
    for (const auto& one : held) answer.push_back(!one.expired());
    return answer;
  };
  ASSERT_TRUE(show_one().has_value());
  ASSERT_TRUE(display_->begin(clock_.now() + 50ms).has_value());
  ASSERT_TRUE(display_->show(nullptr).has_value());
  EXPECT_THAT(alive(), ElementsAre(true)) << "its successor is only queued";
  ASSERT_TRUE(display_->begin(clock_.now() + 50ms).has_value());
  EXPECT_THAT(alive(), ElementsAre(false)) << "its successor is on the screen";
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(show_one().has_value());
  EXPECT_THAT(alive(), ElementsAre(false, false, true, true)) << "one is shown, one is queued";
  EXPECT_EQ(card_.locked.size(), 2u);
  display_.reset();
  EXPECT_THAT(alive(), Each(false));
  EXPECT_TRUE(card_.locked.empty());
}

TEST_F(KmsRig, NeverWaitsBeyondItsDeadline) {
  show_first();
  card_.stuck = true;
  const Instant before = clock_.now();
  const auto late = display_->begin(before + 5ms);
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().kind, FaultKind::timeout);
  EXPECT_EQ(clock_.now(), before + 5ms);
  EXPECT_EQ(display_->show().error().kind, FaultKind::timeout) << "there is no draw target yet";
  card_.stuck = false;
  EXPECT_TRUE(display_->begin(clock_.now() + 50ms).has_value());
}

TEST_F(KmsRig, Row16ALostFlipIsRecoveredByANewModeset) {
  switch_on();
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(show().has_value());
  ASSERT_TRUE(display_->begin(clock_.now() + 50ms).has_value());
  card_.lost_events = 1;
  const Duration took = recover();
  std::printf("row 16, flip event lost: picture after %.0f ms\n", ms(took));
  EXPECT_LE(took, 2s);
  EXPECT_THAT(causes_, testing::IsEmpty()) << "the display stays open";
  EXPECT_EQ(display_->counts().flip_timeouts, 1u);
  EXPECT_EQ(display_->counts().modesets, 2u);
  EXPECT_EQ(card_.count("commit_mode"), 1) << "set again without waiting for the hardware";
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(show().has_value());  // and a later one is recovered as well
  ASSERT_TRUE(display_->begin(clock_.now() + 50ms).has_value());
  card_.lost_events = 1;
  recover();
  EXPECT_THAT(causes_, testing::IsEmpty());
  EXPECT_EQ(display_->counts().flip_timeouts, 2u);
}

TEST_F(KmsRig, Row16AStuckDriverIsReopened) {
  see_first();
  card_.stuck = true;
  const Instant stuck = clock_.now();
  const auto shown = show_until_refused();
  std::printf("row 16, flips never complete: reported after %.0f ms\n", ms(clock_.now() - stuck));
  EXPECT_EQ(shown.error().kind, FaultKind::device);
  EXPECT_LE(clock_.now() - stuck, 2s + 50ms);
  EXPECT_EQ(display_->counts().flip_timeouts, 2u);
  EXPECT_EQ(card_.count("restore"), 0);
  display_.reset();
  EXPECT_EQ(card_.count("restore"), 0) << "a hung driver is not touched again";
  card_.stuck = false;
  std::printf("row 16, flips never complete: picture %.0f ms after reopening\n", ms(recover()));
}

TEST_F(KmsRig, Row16ABusyDriverIsRetried) {
  see_first();
  card_.busy = 5;
  const Duration took = recover();
  std::printf("row 16, EBUSY five times: picture after %.0f ms\n", ms(took));
  EXPECT_LE(took, 100ms);
  EXPECT_EQ(display_->counts().modesets, 1u) << "nothing had to be recovered";
  card_.busy = 1 << 20;
  const Instant busy = clock_.now();
  const auto shown = show_until_refused();
  std::printf("row 16, EBUSY for ever: reported after %.0f ms\n", ms(clock_.now() - busy));
  EXPECT_EQ(shown.error().kind, FaultKind::device);
  EXPECT_LE(clock_.now() - busy, 2s + 50ms);
}

TEST_F(KmsRig, Row16ALostMasterIsReported) {
  see_first();
  card_.master_elsewhere = true;
  system_->users = "Xorg (pid 812) is master";
  EXPECT_THAT(show(), FailsAs(FaultKind::device, AllOf(HasSubstr("DRM master"), HasSubstr("Xorg (pid 812)"))));
  display_.reset();
  EXPECT_EQ(card_.count("restore"), 0) << "the screen belongs to another program";
  EXPECT_THAT(open(), FailsAs(FaultKind::device, AllOf(HasSubstr("DRM master"), HasSubstr("Xorg (pid 812)"))));
  card_.master_elsewhere = false;
  const Duration took = recover();
  std::printf("row 16, DRM master given back: picture after %.0f ms\n", ms(took));
  EXPECT_LE(took, 2s);
}

TEST_F(KmsRig, Row16ALostMasterIsNoticedWhileNothingIsShown) {
  see_first();
  card_.master_elsewhere = true;
  clock_.advance(1s);
  EXPECT_EQ(display_->begin(clock_.now() + 50ms).error().kind, FaultKind::device);
}

TEST_F(KmsRig, ARefusedFlipSetsTheModeAgainOnce) {
  show_first();
  card_.refusals = {std::errc::invalid_argument};  // another program turned the CRTC off
  ASSERT_TRUE(show().has_value());
  ASSERT_TRUE(display_->begin(clock_.now() + 50ms).has_value());
  EXPECT_EQ(display_->counts().modesets, 2u);
  card_.refusals = {std::errc::invalid_argument, std::errc::invalid_argument};
  EXPECT_THAT(show(), FailsAs(FaultKind::device, HasSubstr("Invalid argument")));
}

TEST_F(KmsRig, Row15NoDisplayAtBoot) {
  card_.unplug();
  EXPECT_THAT(open(), FailsAs(FaultKind::disconnected, HasSubstr("HDMI-A-1: disconnected")));
  card_.plug(fake_connector(30, "HDMI-A-1", {fake_mode(64, 48, 60, true)}));
  const Duration took = recover();
  std::printf("row 15, display plugged in after boot: picture after %.0f ms\n", ms(took));
  EXPECT_LE(took, 3s);
}

TEST_F(KmsRig, Row15NoCardAtBoot) {
  card_.present = false;
  EXPECT_EQ(open().error().kind, FaultKind::disconnected);
  options_.device = "/dev/dri/card9";
  EXPECT_EQ(open().error().kind, FaultKind::disconnected);
  card_.present = true;
  EXPECT_LE(recover(), 3s);
}

TEST_F(KmsRig, Row15UnpluggedAndAnotherModeOnReturn) {
  for (const bool with_udev : {true, false}) {
    system_->has_udev = with_udev;
    card_.plug(fake_connector(30, "HDMI-A-1", {fake_mode(64, 48, 60, true)}));
    switch_on();
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(show().has_value());
    card_.unplug(with_udev);
    const Instant pulled = clock_.now();
    const auto shown = show_until_refused();
    EXPECT_EQ(shown.error().kind, FaultKind::disconnected) << shown.error().message;
    std::printf("row 15, unplugged, %s udev: reported after %.0f ms\n", with_udev ? "with" : "without",
                ms(clock_.now() - pulled));
    EXPECT_LE(clock_.now() - pulled, 1s + 50ms);
    display_.reset();
    EXPECT_EQ(open().error().kind, FaultKind::disconnected);
    auto other = fake_connector(30, "HDMI-A-1", {fake_mode(32, 24, 75, true)});
    other.identity = 8;
    card_.plug(other);
    const Duration took = recover();
    std::printf("row 15, another display on return: picture after %.0f ms\n", ms(took));
    EXPECT_LE(took, 3s);
    EXPECT_THAT(display_->description(), HasSubstr("32x24@75.00"));
    const auto target = must(display_->begin(clock_.now() + 50ms));
    EXPECT_EQ(target->width, 32);
    display_.reset();
  }
}

TEST_F(KmsRig, Row15AnotherDisplayIsPluggedInBetweenTwoPictures) {
  show_first();
  auto other = card_.connectors[0];
  other.identity = 8;
  card_.plug(other);
  EXPECT_EQ(show().error().kind, FaultKind::disconnected);
}

TEST_F(KmsRig, Row15ConnectedButWithoutModes) {
  show_first();
  const auto before = card_.connectors[0];
  card_.plug(fake_connector(30, "HDMI-A-1", {}));
  EXPECT_THAT(show(), FailsAs(FaultKind::disconnected, HasSubstr("lists no modes")));
  display_.reset();
  EXPECT_EQ(open().error().kind, FaultKind::disconnected);
  card_.plug(before);
  const Duration took = recover();
  std::printf("row 15, modes listed again: picture after %.0f ms\n", ms(took));
  EXPECT_LE(took, 3s);
}

TEST_F(KmsRig, Row15TheCardDisappears) {
  show_first();
  card_.present = false;
  const auto shown = show_until_refused();
  EXPECT_EQ(shown.error().kind, FaultKind::disconnected);
  display_.reset();
  card_.present = true;
  EXPECT_LE(recover(), 3s);
}

TEST_F(KmsRig, FallsBackToThePreferredModeIfAllowedWhenTheNewDisplayLacksTheRequestedOne) {
  options_.width = 64;
  options_.height = 48;
  card_.plug(fake_connector(30, "HDMI-A-1", {fake_mode(32, 24, 75, true)}));
  EXPECT_EQ(open().error().kind, FaultKind::bad_input);
  options_.preferred_instead = true;
  switch_on();
  EXPECT_THAT(display_->description(), AllOf(HasSubstr("32x24@75.00"), HasSubstr("not offered")));
}

TEST_F(KmsRig, ABadLinkIsRetrained) {
  show_first();
  auto bad = card_.connectors[0];
  bad.link_bad = true;
  card_.plug(bad);
  ASSERT_TRUE(show().has_value());
  EXPECT_EQ(display_->counts().modesets, 2u);
}

TEST_F(KmsRig, DoesNotProbeTheDisplayWithoutReason) {
  switch_on();
  const int before = card_.probes;
  for (int i = 0; i < 600; ++i) ASSERT_TRUE(show().has_value());  // ten seconds
  EXPECT_EQ(card_.probes, before);
  // Nor endlessly during a storm of events: probing a display takes some 10 ms.
  for (int i = 0; i < 60; ++i) {
    card_.changed = true;
    ASSERT_TRUE(show().has_value());
  }
  EXPECT_LE(card_.probes, before + 5);
}

TEST_F(KmsRig, TurnsTheScreenOffAndTheNextPictureWakesIt) {
  for (const bool atomic : {true, false}) {
    options_.atomic = atomic;
    display_.reset();
    switch_on();
    ASSERT_TRUE(show());
    ASSERT_TRUE(display_->begin(clock_.now() + 50ms));  // the first one has arrived
    const auto off = display_->turn_off();
    ASSERT_TRUE(off) << off.error().message;
    EXPECT_TRUE(card_.asleep);
    const auto modes = display_->counts().modesets;
    const auto flips = display_->counts().flips;
    clock_.advance(8h);
    const auto woken = show();
    ASSERT_TRUE(woken) << woken.error().message;
    ASSERT_TRUE(display_->begin(clock_.now() + 50ms));
    EXPECT_FALSE(card_.asleep);
    EXPECT_EQ(display_->counts().modesets, modes + 1);
    EXPECT_EQ(display_->counts().flips, flips + 1);
    EXPECT_EQ(display_->counts().flip_timeouts, 0u);
  }
}

TEST_F(KmsRig, DistinguishesScreensThatCannotTurnOffAreBusyOrAreLost) {
  switch_on();
  EXPECT_EQ(display_->turn_off().error().kind, FaultKind::unsupported) << "it is not ours before the first picture";
  ASSERT_TRUE(show());
  EXPECT_EQ(display_->turn_off().error().kind, FaultKind::timeout) << "the picture is on its way";
  ASSERT_TRUE(display_->begin(clock_.now() + 50ms));
  card_.busy = 1;
  EXPECT_EQ(display_->turn_off().error().kind, FaultKind::timeout);
  card_.refusals = {std::errc::invalid_argument};
  EXPECT_EQ(display_->turn_off().error().kind, FaultKind::unsupported);
  card_.master_elsewhere = true;
  EXPECT_EQ(display_->turn_off().error().kind, FaultKind::device);
  EXPECT_FALSE(card_.asleep);
}

TEST_F(KmsRig, Row17ALostContextIsReported) {
  show_first();
  card_.gl_lost = true;
  EXPECT_THAT(show(), FailsAs(FaultKind::device, HasSubstr("GL context lost")));
  display_.reset();
  card_.gl_lost = false;
  const Duration took = recover();
  std::printf("row 17, GL context lost: picture after %.0f ms\n", ms(took));
  EXPECT_LE(took, 1s);
}

TEST_F(KmsRig, RestoresTheConsoleBeforeItsFramebuffersAreFreed) {
  switch_on();
  for (int i = 0; i < 2; ++i) ASSERT_TRUE(show().has_value());
  ASSERT_TRUE(display_->begin(clock_.now() + 50ms).has_value());
  display_.reset();
  const auto restored = std::ranges::find(card_.calls, "restore");
  const auto removed = std::ranges::find(card_.calls, "remove_framebuffer");
  ASSERT_NE(restored, card_.calls.end());
  ASSERT_NE(removed, card_.calls.end());
  EXPECT_LT(restored - card_.calls.begin(), removed - card_.calls.begin());
}

TEST_F(KmsRig, LeavesNothingOpenWhenDestroyed) {
  switch_on();  // what the GL driver keeps permanently is allocated now
  display_.reset();
  const std::size_t before = open_descriptors();
  for (int i = 0; i < 50; ++i) {
    switch_on();
    for (int picture = 0; picture < 3; ++picture) ASSERT_TRUE(show().has_value());
    if (i % 2 == 0) card_.unplug();
    (void)show();
    display_.reset();
    card_.plug(fake_connector(30, "HDMI-A-1", {fake_mode(64, 48, 60, true)}));
  }
  EXPECT_EQ(open_descriptors(), before);
  EXPECT_EQ(card_.open_devices, 0);
  EXPECT_TRUE(card_.framebuffers.empty());
  EXPECT_TRUE(card_.locked.empty());
}

TEST_F(KmsRig, FlipsThatAreNeverCollectedDoNotPileUp) {
  switch_on();
  for (int i = 0; i < 1000; ++i) ASSERT_TRUE(show().has_value());
  EXPECT_LE(display_->take_flips().size(), 256u);
  EXPECT_GE(display_->counts().flips, 999u);
}

TEST_F(KmsRig, ListsCardsWithoutBecomingMaster) {
  system_->users = "kasumi (pid 411) is master";
  const auto cards = list_displays(*system_);
  ASSERT_EQ(cards.size(), 1u);
  EXPECT_EQ(cards[0].path, "/dev/dri/card9");
  EXPECT_EQ(cards[0].by_path, "/dev/dri/by-path/fake-card");
  EXPECT_EQ(cards[0].driver, "fake");
  EXPECT_TRUE(cards[0].atomic);
  EXPECT_EQ(cards[0].users, "kasumi (pid 411) is master");
  ASSERT_EQ(cards[0].connectors.size(), 1u);
  EXPECT_EQ(cards[0].connectors[0].connection, "connected");
  EXPECT_EQ(cards[0].connectors[0].preferred, "64x48@60.00");
  EXPECT_EQ(cards[0].connectors[0].modes.size(), 3u);
  EXPECT_EQ(card_.count("drop_master"), 1);
  EXPECT_EQ(card_.open_devices, 0);
}

TEST_F(KmsRig, ListsWhatTheDisplayMayLayABuildingOver) {
  EXPECT_THAT(list_displays(*system_)[0].plane_formats, ElementsAre("XR24"));
  card_.planes[0].formats.push_back(drm_format("NV12"));
  EXPECT_THAT(list_displays(*system_)[0].plane_formats, ElementsAre("XR24")) << "it cannot be told to convert";
  card_.planes[0].encodings = {YuvEncoding::bt709_limited};
  EXPECT_THAT(list_displays(*system_)[0].plane_formats, ElementsAre("XR24", "NV12"));
  EXPECT_EQ(list_displays(*system_)[0].no_planes, "");
  card_.planes[0].formats.push_back(drm_format("XR30"));
  card_.planes[1].premultiplied = true;
  card_.planes[1].zpos = {.now = 2, .least = 1, .most = 7};
  EXPECT_THAT(
      list_displays(*system_)[0].planes,
      ElementsAre("primary: XR24 AR24 NV12 and 1 others; blending not said; height not said; converts bt709_limited",
                  "overlay: XR24 AR24; premultiplied; height 1 to 7"));
  card_.planes.resize(1);  // virtio_gpu
  EXPECT_EQ(list_displays(*system_)[0].no_planes, "the display has no overlay plane");
  card_.has_atomic = false;
  EXPECT_THAT(list_displays(*system_)[0].no_planes, HasSubstr("no atomic commits"));
}

TEST_F(KmsRig, MeasuresItsFlips) {
  switch_on();
  const auto timing = must(measure_flips(*display_, clock_, 20));
  EXPECT_EQ(timing->flips, 20);
  EXPECT_EQ(timing->median_interval, card_.refresh);
  EXPECT_EQ(timing->longest_interval, card_.refresh);
  EXPECT_LE(timing->median_latency, card_.refresh);
  EXPECT_EQ(measure_flips(*display_, clock_, 1).error().kind, FaultKind::bad_input);
}

}  // namespace
}  // namespace kasumi
