// The ladder alone: inputs in, rungs out.
#include <gtest/gtest.h>

#include <random>

#include "pipeline/site/config/ladder.hpp"

namespace kasumi {
namespace {

using namespace std::chrono_literals;

class LadderTest : public testing::Test {
 protected:
  // The picture of `age` is shown; all other inputs are good.
  Rung at(Duration now, std::optional<Duration> age) {
    input.picture_age = age;
    return ladder.step(Instant{now}, input);
  }
  // Fresh pictures until the rung is steady.
  void settle(Duration until) {
    for (Duration now = until - 5s; now <= until; now += 40ms) at(now, 20ms);
  }
  Ladder ladder;
  LadderInput input{.picture_age = {}, .bad_scene_picture = {}, .sky_up = true, .sun_known = true, .open = true};
};

TEST_F(LadderTest, BeforeTheFirstPictureTheStillIsThereAtOnce) {
  const auto rung = at(0s, std::nullopt);
  EXPECT_EQ(rung.shown, Shown::still);
  EXPECT_EQ(rung.trouble, Trouble::starting);
  EXPECT_EQ(rung.still, 1.0);
}

// Whatever is wrong at the start and however long it lasts: nothing shines through, neither the scene nor black.
TEST_F(LadderTest, TheFirstStillIsOpaqueFromItsFirstPictureOn) {
  for (const auto bad : {std::optional<Trouble>{}, std::optional{Trouble::scene_covered}})
    for (const auto age : {std::optional<Duration>{}, std::optional<Duration>{10s}}) {
      ladder = Ladder();
      input.bad_scene_picture = bad;
      for (Duration now = 0s; now < 3s; now += 33ms) {
        const auto rung = at(now, age);
        ASSERT_EQ(rung.shown, Shown::still);
        ASSERT_EQ(rung.still, 1.0) << "at " << to_seconds(now) << " s";
        ASSERT_EQ(rung.dark, 0.0);
      }
    }
}

TEST_F(LadderTest, ClosedAtTheStartItIsBlackAtOnce) {
  input.open = false;
  EXPECT_EQ(at(0s, std::nullopt).dark, 1.0) << "no still flashes up at night";
}

TEST_F(LadderTest, TheFirstPictureIsShownWithoutWaiting) {
  at(0s, std::nullopt);
  EXPECT_EQ(at(1s, 0ms).shown, Shown::live);
}

TEST_F(LadderTest, AnOldPictureIsHeldAndCoveredByTheStillWhenItIsTwoSecondsOld) {
  settle(10s);
  EXPECT_EQ(at(11s, 400ms).shown, Shown::live);
  EXPECT_EQ(at(11s + 200ms, 600ms).shown, Shown::held);
  EXPECT_EQ(at(12s + 100ms, 1500ms).shown, Shown::held);
  for (Duration age = 1520ms; age < 2s; age += 20ms) at(12s + 100ms + (age - 1500ms), age);
  const auto rung = at(12s + 600ms, 2s);
  EXPECT_EQ(rung.shown, Shown::still);
  EXPECT_EQ(rung.trouble, Trouble::scene_lost);
  EXPECT_EQ(rung.still, 1.0) << "no picture older than two seconds is seen";
}

TEST_F(LadderTest, TheFadeDoesNotDependOnHowOftenItIsCalled) {
  for (const Duration step : {10ms, 50ms, 130ms}) {
    Ladder fading;
    input.picture_age = 20ms;
    for (Duration now{}; now < 5s; now += 50ms) fading.step(Instant{now}, input);
    input.bad_scene_picture = Trouble::scene_covered;
    Duration now = 5s;
    double opacity = fading.step(Instant{now}, input).still;
    const auto began = now;
    while (opacity < 1.0) opacity = fading.step(Instant{now += step}, input).still;
    EXPECT_NEAR(to_seconds(now - began), 0.4, to_seconds(step) + 0.05);
    input.bad_scene_picture.reset();
  }
}

TEST_F(LadderTest, ACameraThatComesAndGoesDoesNotMakeTheScreenFlicker) {
  settle(10s);
  for (Duration now = 10s; now < 14s; now += 20ms) at(now, now - 10s + 20ms);
  EXPECT_EQ(at(14s, 4s).shown, Shown::still);
  // One frame every 2.5 s: each is young for a moment.
  int changes = 0;
  auto last = Shown::still;
  for (Duration now = 14s; now < 34s; now += 20ms) {
    const auto since = (now - 14s) % 2500ms;
    const auto shown = at(now, since).shown;
    // Live and held are the same picture.
    const bool still = shown == Shown::still, was = last == Shown::still;
    if (still != was) ++changes;
    last = shown;
  }
  EXPECT_LE(changes, 2 * 8) << "at most once there and back for each frame";
  // Frames for 0.3 s only never lift the still.
  Ladder other;
  LadderInput seen = input;
  seen.picture_age = 10ms;
  other.step(Instant{0s}, seen);
  seen.picture_age = 3s;
  other.step(Instant{3s}, seen);
  for (Duration now = 3s + 20ms; now < 3s + 320ms; now += 20ms) {
    seen.picture_age = 10ms;
    EXPECT_EQ(other.step(Instant{now}, seen).shown, Shown::still);
  }
}

TEST_F(LadderTest, WithoutTheSkyCameraThePictureIsLiveUnderAnEarlierAir) {
  settle(10s);
  input.sky_up = false;
  const auto rung = at(10s + 40ms, 20ms);
  EXPECT_EQ(rung.shown, Shown::degraded);
  EXPECT_EQ(rung.trouble, Trouble::sky_lost);
  EXPECT_EQ(rung.still, 0.0);
}

TEST_F(LadderTest, WithoutATrustedTimeThePictureIsLiveAndTheReasonIsGiven) {
  settle(10s);
  input.sun_known = false;
  input.sky_up = false;
  EXPECT_EQ(at(10s + 40ms, 20ms).trouble, Trouble::time_unknown);
}

TEST_F(LadderTest, OutsideOpeningHoursItIsDarkAndThatIsNoFault) {
  settle(10s);
  input.open = false;
  for (Duration now = 10s; now < 11s; now += 20ms) at(now, 20ms);
  const auto rung = at(11s, 20ms);
  EXPECT_EQ(rung.shown, Shown::dark);
  EXPECT_EQ(rung.trouble, Trouble::closed);
  EXPECT_EQ(rung.dark, 1.0);
  input.open = true;
  for (Duration now = 11s; now < 12s; now += 20ms) at(now, 20ms);
  EXPECT_EQ(at(12s, 20ms).shown, Shown::live);
  EXPECT_EQ(at(12s, 20ms).dark, 0.0);
}

TEST_F(LadderTest, ASlowCameraGetsLongerDeadlines) {
  const auto options = patient_with({}, 5s);
  EXPECT_EQ(options.held, 12500ms);
  EXPECT_EQ(patient_with({}, 40ms).held, 2s);
}

// Whatever happens: no picture older than allowed is seen, opacities stay in 0..1 and move no faster than the fade.
TEST_F(LadderTest, NoOrderOfEventsShowsAPictureThatIsTooOld) {
  std::mt19937_64 random(7);
  const auto chance = [&](double p) { return static_cast<double>(random() >> 11) * 0x1p-53 < p; };
  Duration picture = 0s;
  bool camera = true;
  Rung last;
  for (Duration now = 0s; now < 3600s; now += 20ms) {
    if (chance(0.004)) camera = !camera;
    if (camera && chance(0.6)) picture = now;
    if (chance(0.002)) input.sky_up = !input.sky_up;
    if (chance(0.001)) input.sun_known = !input.sun_known;
    if (chance(0.001))
      input.bad_scene_picture = input.bad_scene_picture ? std::nullopt : std::optional(Trouble::scene_frozen);
    const auto rung = at(now, now - picture);
    const auto& options = LadderTimes{};
    if (now - picture > options.held + 20ms) {
      ASSERT_EQ(rung.still, 1.0) << to_seconds(now);
    }
    ASSERT_GE(rung.still, 0.0);
    ASSERT_LE(rung.still, 1.0);
    if (now > 0s) {
      ASSERT_LE(std::abs(rung.still - last.still), 0.02 / 0.4 + 1e-9) << to_seconds(now);
    }
    ASSERT_EQ(rung.shown == Shown::live, rung.trouble == Trouble::none && rung.shown != Shown::held);
    last = rung;
  }
}

}  // namespace
}  // namespace kasumi
