// What may go wrong with cameras, air and time, and what the visitor sees meanwhile (design: faults, by row).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "pipeline/kiosk/start/remembered_state.hpp"
#include "tests/pipeline/kiosk/appliance/journal.hpp"
#include "tests/pipeline/kiosk/appliance/rig.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

// Nothing on the screen is ever older than the ladder allows.
void advance_watching(Rig& rig, Duration by) {
  for (Duration turned{}; turned < by; turned += Rig::kTick) {
    rig.advance(Rig::kTick);
    if (const auto age = rig.age_on_screen()) {
      ASSERT_LE(to_seconds(*age), 2.05);
    }
  }
}

TEST(Appliance, TheStillAppearsFirstAndThePictureFollows) {
  Rig rig({.name = "start"});
  rig.devices.scene.silent = true;
  rig.appliance->render().step();
  EXPECT_TRUE(rig.shows_still()) << "in the first step, before any time has passed";
  EXPECT_EQ(rig.notifier.readies, 1);
  rig.advance(100ms);
  EXPECT_TRUE(rig.shows_still());
  EXPECT_EQ(rig.trouble(), Trouble::starting);
  EXPECT_EQ(rig.notifier.readies, 1) << "the start picture counts as a picture";
  rig.devices.scene.silent = false;
  EXPECT_TRUE(rig.recover("start", 2s));
  EXPECT_EQ(rig.notifier.readies, 1);
}

TEST(Appliance, Row1SceneCameraUnpluggedAndReplugged) {
  const auto rig = running({.name = "row1"});
  rig->devices.scene.unplugged = true;
  rig->advance(1s);
  EXPECT_EQ(rig->shown(), Shown::held);
  EXPECT_TRUE(rig->age_on_screen());
  rig->advance(2s);
  EXPECT_EQ(rig->shown(), Shown::still);
  EXPECT_EQ(rig->trouble(), Trouble::scene_lost);
  EXPECT_TRUE(rig->shows_still());
  EXPECT_FALSE(rig->status().scene_camera.health.up);
  EXPECT_EQ(rig->status().scene_camera.health.cause, "unplugged");
  EXPECT_EQ(rig->status().render.camera_buffers_dropped, 1u) << "the GPU gave the driver's memory back";
  rig->advance(60s);
  EXPECT_EQ(rig->shown(), Shown::still);
  rig->devices.scene.unplugged = false;
  EXPECT_TRUE(rig->recover("1 scene camera unplugged, replugged", 3s));
}

// It came while the display was busy; its buffer is the driver's, which has gone.
TEST(Appliance, Row1AFrameFromBeforeTheOutageIsNotShownAfterIt) {
  const auto rig = running({.name = "row1-before"});
  const auto shown = frame_number(rig->picture());
  ASSERT_TRUE(shown);
  const auto frames = rig->status().scene_camera.health.good_frames;
  rig->devices.display.stuck = true;
  rig->advance(2 * kSceneInterval);
  ASSERT_GT(rig->status().scene_camera.health.good_frames, frames);
  rig->devices.scene.unplugged = true;
  rig->advance(100ms);
  ASSERT_FALSE(rig->status().scene_camera.health.up);
  rig->devices.display.stuck = false;
  for (int i = 0; i < 5; ++i) {
    rig->advance(Rig::kTick);
    EXPECT_EQ(frame_number(rig->picture()), shown);
  }
}

TEST(Appliance, Row2UnpluggingTheSkyCameraChangesOnlyTheAgeOfTheAir) {
  const auto rig = running({.name = "row2"});
  const auto before = rig->status().sky.report.seen_air()->air.turbidity().value;
  rig->devices.sky.unplugged = true;
  rig->advance(60s);
  EXPECT_EQ(rig->shown(), Shown::degraded);
  EXPECT_TRUE(rig->age_on_screen());
  ASSERT_TRUE(rig->status().sky.report.seen_air());
  EXPECT_NEAR(rig->status().sky.report.seen_air()->air.turbidity().value, before, 0.02);
  EXPECT_GT(to_seconds(rig->status().sky.report.seen_air()->age), 50.0);
  EXPECT_TRUE(rig->status().sky.sun_known()) << "the sun moves on by the clock";
  rig->devices.sky.unplugged = false;
  EXPECT_TRUE(rig->recover("2 sky camera unplugged, replugged", 3s));
}

TEST(Appliance, Row4OpeningACameraIsRetried) {
  const auto rig = running({.name = "row4"});
  rig->devices.scene.fatal_queue = true;
  rig->devices.scene.open_fails = "VIDIOC_STREAMON: ENOSPC";
  rig->advance(5s);
  EXPECT_EQ(rig->shown(), Shown::still);
  EXPECT_THAT(rig->status().scene_camera.health.cause, HasSubstr("ENOSPC"));
  rig->devices.scene.open_fails.clear();
  EXPECT_TRUE(rig->recover("4 STREAMON fails for 5 s", 18s));
}

TEST(Appliance, Row5AStreamWithoutFramesIsReopened) {
  Rig rig({.name = "row5"});
  rig.devices.scene.silent = true;
  rig.advance(4500ms);
  EXPECT_EQ(rig.status().scene_camera.health.opened, 1u);
  EXPECT_THAT(rig.status().scene_camera.health.cause, HasSubstr("first frame"));
  rig.advance(2s);
  EXPECT_EQ(rig.status().scene_camera.health.opened, 2u);
  rig.devices.scene.silent = false;
  EXPECT_TRUE(rig.recover("5 STREAMON works, no frame", 4s));
}

TEST(Appliance, Row6AStallIsNoticedInTwoSeconds) {
  const auto rig = running({.name = "row6"});
  rig->devices.scene.silent = true;
  advance_watching(*rig, 2400ms);
  EXPECT_THAT(rig->status().scene_camera.health.cause, HasSubstr("stall"));
  EXPECT_EQ(rig->shown(), Shown::still);
  rig->devices.scene.silent = false;
  EXPECT_TRUE(rig->recover("6 stall mid-stream, noticed", 5s));
  EXPECT_EQ(rig->status().scene_camera.health.reopened.at("stall"), 1u);
}

TEST(Appliance, Row7AFatalQueueErrorIsRecoveredBeforeThePictureIsTooOld) {
  const auto rig = running({.name = "row7"});
  rig->devices.scene.fatal_queue = true;
  bool still = false;
  rig->advance(40ms);
  const auto took = rig->advance_until(
      [&] {
        still = still || rig->shown() == Shown::still;
        return rig->devices.scene.opened == 2 && rig->shown() == Shown::live;
      },
      3s);
  ASSERT_TRUE(took);
  std::printf("%-52s live after %.2f s\n", "7 fatal queue error", to_seconds(*took));
  EXPECT_LE(*took, 2s);
  EXPECT_FALSE(still) << "holding the picture was enough";
}

struct BadKind {
  const char* name;
  void (*spoil)(Frame&);
};
class BadFrames : public testing::TestWithParam<BadKind> {};

TEST_P(BadFrames, Row8ThePreviousFrameStays) {
  const auto [name, spoil] = GetParam();
  const auto rig = running({.name = std::string("row8-") + name});
  const auto good = rig->status().scene_camera.health.good_frames;
  int spoilt = 0;
  rig->devices.scene.spoil = [&spoilt, spoil = spoil](Frame& frame) {
    if (spoilt++ < 3) spoil(frame);
  };
  for (int i = 0; i < 60; ++i) {
    rig->advance(Rig::kTick);
    EXPECT_NE(rig->shown(), Shown::still);
    EXPECT_TRUE(rig->age_on_screen()) << "the previous frame, whole";
  }
  EXPECT_EQ(rig->shown(), Shown::live);
  std::uint64_t bad = 0;
  for (const auto& [reason, count] : rig->status().scene_camera.health.bad_frames) bad += count;
  EXPECT_EQ(bad, 3u);
  EXPECT_GE(rig->status().scene_camera.health.good_frames, good + 2);
  EXPECT_EQ(rig->status().scene_camera.health.opened, 1u) << "the camera was not reopened";
  std::printf("8 %-50s next frame\n", name);
}

INSTANTIATE_TEST_SUITE_P(Kinds, BadFrames,
                         testing::Values(BadKind{"flagged", flag_as_error}, BadKind{"truncated", truncate},
                                         BadKind{"empty", empty}, BadKind{"foreign_jpeg", replace_by_rubbish_jpeg}),
                         [](const testing::TestParamInfo<BadKind>& kind) { return std::string(kind.param.name); });

TEST(Appliance, Row9WhenEveryFrameIsBadTheCameraIsReopened) {
  const auto rig = running({.name = "row9"});
  bool first_opening = true;
  rig->devices.scene.spoil = [&](Frame& frame) {
    if (first_opening) replace_by_rubbish_jpeg(frame);
  };
  rig->advance(5s);
  EXPECT_EQ(rig->shown(), Shown::still);
  const auto took = rig->advance_until(
      [&] {
        if (rig->devices.scene.opened == 2) first_opening = false;
        return rig->shown() == Shown::live;
      },
      15s);
  ASSERT_TRUE(took);
  std::printf("%-52s live after %.2f s\n", "9 every frame bad", 5.0 + to_seconds(*took));
  EXPECT_LE(*took + 5s, 15s);
  rig->advance(600ms);
  EXPECT_EQ(rig->status().scene_camera.health.reopened.at("bad frames"), 1u);
}

TEST(Appliance, Row10FramesOfAnotherSizeNeverReachTheScreen) {
  const auto rig = running({.name = "row10"});
  rig->devices.scene.spoil = halve_size;
  advance_watching(*rig, 3s);
  EXPECT_EQ(rig->shown(), Shown::still);
  EXPECT_THAT(rig->status().scene_camera.health.bad_frames, testing::Contains(testing::Key(HasSubstr("160x90"))));
  rig->devices.scene.spoil = {};
  EXPECT_TRUE(rig->recover("10 another size, then the right one", 1s));
}

TEST(Appliance, Row11TimestampsThatRunBackwardsAreCountedAndNotVisible) {
  const auto rig = running({.name = "row11"});
  rig->devices.scene.spoil = run_backwards();
  for (int i = 0; i < 200; ++i) {
    rig->advance(Rig::kTick);
    ASSERT_EQ(rig->shown(), Shown::live);
  }
  EXPECT_GT(rig->status().scene_camera.health.backwards, 5u);
  EXPECT_GT(rig->status().scene_camera.health.sequence_gaps, 5u);
  std::printf("%-52s at once\n", "11 timestamps back, sequence gaps");
}

struct Blind {
  const char* name;
  std::function<void(Frame&)> spoil;
  Trouble trouble;
};
class BlindCamera : public testing::TestWithParam<int> {};

TEST_P(BlindCamera, Row12AfterHalfAMinuteTheStillIsShownUntilThePictureIsNormalAgain) {
  const Blind blind = GetParam() == 0   ? Blind{"frozen", freeze(), Trouble::scene_frozen}
                      : GetParam() == 1 ? Blind{"covered", cover, Trouble::scene_covered}
                                        : Blind{"white-out", white_out, Trouble::scene_white_out};
  const auto rig = running({.name = std::string("row12-") + blind.name});
  rig->devices.scene.spoil = blind.spoil;
  rig->advance(28s);
  EXPECT_EQ(rig->shown(), Shown::live);
  rig->advance(5s);
  EXPECT_EQ(rig->shown(), Shown::still);
  EXPECT_EQ(rig->trouble(), blind.trouble);
  EXPECT_TRUE(rig->shows_still());
  rig->devices.scene.spoil = {};
  EXPECT_TRUE(rig->recover(fmt::format("12 {}", blind.name), 3s));
}
INSTANTIATE_TEST_SUITE_P(Ways, BlindCamera, testing::Values(0, 1, 2));

// An earlier sky would be read under a sun that has moved on.
TEST(Appliance, AFrozenSkyIsNotEstimatedUntilItMovesAgain) {
  auto estimates = std::make_shared<int>(0);
  ObservationPlan sky;
  sky.estimator = [estimates](const SkyPicture&, const SunDirection&) {
    ++*estimates;
    TurbidityEstimate estimate;
    estimate.usable = true;
    estimate.sky = SkyCondition::clear;
    estimate.turbidity = {3.0};
    estimate.sigma = 0.05;
    return estimate;
  };
  const auto rig = running({.name = "frozen-sky", .sky = sky});
  const Journal journal;
  // Looks at its condition and estimates are due once a second each: opened anew, they are not due together.
  const int first = *estimates;
  ASSERT_TRUE(rig->advance_until([&] { return *estimates > first; }, 2s));
  rig->devices.sky.unplugged = true;
  rig->advance(200ms);
  rig->devices.sky.unplugged = false;
  rig->advance(3s);
  rig->devices.sky.spoil = freeze();
  ASSERT_TRUE(rig->advance_until([&] { return journal.count("sky camera: picture is frozen") == 1; }, 40s));
  const int before = *estimates;
  rig->advance(3s);
  EXPECT_EQ(*estimates, before);
  const auto& status = rig->status();
  EXPECT_FALSE(status.sky.up);
  EXPECT_FALSE(status.sky.report.estimate.usable);
  EXPECT_EQ(status.sky.report.estimate.reason, "no picture of the sky: frozen");
  EXPECT_GE(status.sky.report.seen_air()->age, 2s);
  EXPECT_EQ(rig->trouble(), Trouble::sky_lost);
  EXPECT_EQ(rig->shown(), Shown::degraded);

  rig->devices.sky.spoil = {};
  ASSERT_TRUE(rig->advance_until([&] { return journal.count("sky camera: picture normal again") == 1; }, 3s));
  EXPECT_EQ(*estimates, before + 1) << "with the first picture that moves";
  EXPECT_TRUE(rig->advance_until([&] { return rig->trouble() == Trouble::none; }, 2s));
}

// What a bird, rain or glare does to an estimate: one look that says something else.
TEST(Appliance, Row13ASingleOutlierChangesNothing) {
  auto turbidity = std::make_shared<double>(3.0);
  ObservationPlan sky;
  sky.estimator = [turbidity](const SkyPicture&, const SunDirection&) {
    TurbidityEstimate estimate;
    estimate.usable = true;
    estimate.sky = SkyCondition::clear;
    estimate.turbidity = {*turbidity};
    estimate.sigma = 0.05;
    return estimate;
  };
  const auto rig = running({.name = "row13", .sky = sky});
  rig->advance(30s);
  ASSERT_NEAR(rig->status().sky.report.seen_air()->air.turbidity().value, 3.0, 0.01);
  *turbidity = 9.0;
  rig->advance(4s);
  *turbidity = 3.0;
  rig->advance(4s);
  EXPECT_NEAR(rig->status().sky.report.seen_air()->air.turbidity().value, 3.0, 0.02);
  std::printf("%-52s next good look\n", "13 a bird before the sky");
}

class Nonsense : public testing::TestWithParam<std::pair<double, double>> {};

TEST_P(Nonsense, Row14IsRejectedAndTheLastGoodAirStays) {
  auto answer = std::make_shared<std::pair<double, double>>(3.0, 0.05);
  ObservationPlan sky;
  sky.estimator = [answer](const SkyPicture&, const SunDirection&) {
    TurbidityEstimate estimate;
    estimate.usable = true;
    estimate.sky = SkyCondition::clear;
    estimate.turbidity = {answer->first};
    estimate.sigma = answer->second;
    return estimate;
  };
  const auto rig = running({.name = "row14", .sky = sky});
  *answer = GetParam();
  rig->advance(20s);
  EXPECT_EQ(rig->shown(), Shown::live);
  EXPECT_NEAR(rig->status().sky.report.seen_air()->air.turbidity().value, 3.0, 0.01) << "and what is usual";
  EXPECT_FALSE(rig->status().sky.report.estimate.usable);
  EXPECT_THAT(rig->status().sky.report.estimate.reason, HasSubstr("rejected"));
  std::printf("14 T = %g +- %g %-34s rejected\n", GetParam().first, GetParam().second, "");
}
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
INSTANTIATE_TEST_SUITE_P(Kinds, Nonsense,
                         testing::Values(std::pair(kNaN, 0.1), std::pair(3.0, kNaN), std::pair(kInfinity, 0.1),
                                         std::pair(-4.0, 0.1), std::pair(1e6, 0.1), std::pair(0.2, 0.1),
                                         std::pair(3.0, -1.0), std::pair(3.0, kInfinity)));

constexpr Utc k1970{};

TEST(Appliance, Row24WithTheClockAt1970ThePictureIsLiveWithoutTheBuilding) {
  Rig rig({.name = "row24", .clock_policy = "synchronized", .utc = k1970});
  rig.advance(6s);
  EXPECT_EQ(rig.shown(), Shown::degraded);
  EXPECT_EQ(rig.trouble(), Trouble::time_unknown);
  EXPECT_TRUE(rig.age_on_screen());
  EXPECT_FALSE(rig.status().sky.sun_known());
  EXPECT_FALSE(rig.status().sky.report.seen_air()) << "no estimate without the sun's position";
  const auto without_building = rig.picture();

  // The time server answers: the kernel's clock is set, then it is synchronized.
  rig.time.state.jumps = 1;
  rig.advance(1s);
  EXPECT_FALSE(rig.status().sky.clock_trusted) << "being set is not being synchronized";
  rig.time.state.synchronized = true;
  const auto took = rig.advance_until([&] { return rig.status().sky.clock_trusted; }, 5s);
  EXPECT_FALSE(took) << "a time before earliest_utc is never trusted, whatever the kernel says";
}

TEST(Appliance, Row24OnceSynchronizedTheBuildingAppears) {
  Rig rig({.name = "row24-sync", .clock_policy = "synchronized"});
  rig.advance(6s);
  ASSERT_EQ(rig.trouble(), Trouble::time_unknown);
  rig.time.state = {.synchronized = true, .jumps = 1};
  EXPECT_TRUE(rig.recover("24 clock not in step, then synchronised", 3s));
  EXPECT_TRUE(rig.status().sky.clock_trusted);
  // Somebody sets the clock by hand.
  rig.time.state = {.synchronized = false, .jumps = 2};
  rig.advance(4s);
  EXPECT_EQ(rig.trouble(), Trouble::time_unknown);
  EXPECT_EQ(rig.shown(), Shown::degraded);
}

TEST(Appliance, Row35TrustInTheClockOutlivesAReload) {
  Rig rig({.name = "row35", .clock_policy = "synchronized"});
  rig.time.state.synchronized = true;
  rig.advance(6s);
  ASSERT_EQ(rig.shown(), Shown::live);
  rig.time.state.synchronized = false;  // its time server has been gone for a day
  replace_in(rig.config, "language = \"en\"", "language = \"ja\"");
  rig.hang_up();
  rig.advance(3s);
  EXPECT_TRUE(rig.status().reload->problems.empty());
  EXPECT_EQ(rig.shown(), Shown::live) << name_of(rig.trouble());
  EXPECT_TRUE(rig.status().sky.clock_trusted);
}

TEST(Appliance, Row24WithPolicyFromSkyTheSunIsLocatedInThePicture) {
  Rig rig({.name = "row24-sky", .clock_policy = "from_sky", .utc = k1970});
  rig.advance(6s);
  EXPECT_EQ(rig.shown(), Shown::live);
  EXPECT_EQ(rig.status().sky.report.sun.source, SunSource::image);
  ASSERT_TRUE(rig.status().sky.report.seen_air());
  EXPECT_NEAR(rig.status().sky.report.seen_air()->air.turbidity().value, 2.5, 0.25) << "the generator's";
}

TEST(Appliance, Row24CloudsOverTheSunDoNotTakeTheBuildingAway) {
  Rig rig({.name = "row24-clouds", .clock_policy = "from_sky", .utc = k1970, .observe_every = 30s});
  rig.advance(6s);
  ASSERT_EQ(rig.shown(), Shown::live);
  rig.devices.sky.spoil = cloud_over;
  rig.advance(5min, 5s);
  EXPECT_TRUE(rig.status().sky.sun_known()) << "as it was last seen";
  rig.advance(6min, 5s);
  EXPECT_FALSE(rig.status().sky.sun_known()) << "after ten minutes it stands elsewhere";
}

TEST(Appliance, TheAirIsRestoredAfterARestart) {
  {
    const auto rig = running({.name = "remember"});
    rig->appliance->status().finish();
  }
  Rig rig({.name = "remember",
           .utc = std::chrono::sys_days{std::chrono::June / 21 / 2026} + 3h + 10min,
           .keep_folder = true});
  rig.devices.sky.unplugged = true;
  rig.advance(4s);
  EXPECT_EQ(rig.shown(), Shown::degraded);
  ASSERT_TRUE(rig.status().sky.report.seen_air());
  EXPECT_NEAR(rig.status().sky.report.seen_air()->air.turbidity().value, 2.5, 0.25);
  EXPECT_NEAR(to_seconds(rig.status().sky.report.seen_air()->age), 600.0, 10.0);
}

TEST(Appliance, AirOfMoreThanTwoHoursAgoIsNotRestored) {
  {
    const auto rig = running({.name = "remember-long"});
    rig->appliance->status().finish();
  }
  Rig rig({.name = "remember-long",
           .utc = std::chrono::sys_days{std::chrono::June / 21 / 2026} + 3h + 2h + 10min,
           .keep_folder = true});
  rig.devices.sky.unplugged = true;
  rig.advance(4s);
  EXPECT_FALSE(rig.status().sky.report.seen_air());
}

TEST(Appliance, AirOfTheOtherSkyModelIsNotRestored) {
  {
    const auto rig = running({.name = "remember-other"});
    rig->appliance->status().finish();
    // A T that was followed alone.
    const TurbidityState papers{{2.5}, 0.1, Utc{std::chrono::sys_days{std::chrono::June / 21 / 2026} + 3h}};
    ASSERT_TRUE(save(papers, rig->folder / "state"));
  }
  Rig rig({.name = "remember-other",
           .utc = std::chrono::sys_days{std::chrono::June / 21 / 2026} + 3h + 10min,
           .keep_folder = true});
  rig.devices.sky.unplugged = true;
  rig.advance(4s);
  EXPECT_FALSE(rig.status().sky.report.seen_air());
}

}  // namespace
}  // namespace kasumi
