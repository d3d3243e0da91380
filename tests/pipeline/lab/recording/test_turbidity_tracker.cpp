#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "pipeline/lab/recording/turbidity_tracker.hpp"
#include "tests/estimator/turbidity/synthetic_sky.hpp"

namespace kasumi {
namespace {

using namespace std::chrono;
using Verdict = TurbidityTracker::Verdict;

TurbidityEstimate seen_t(double t, double sigma = 0.02) {
  TurbidityEstimate estimate;
  estimate.usable = true;
  estimate.turbidity = Turbidity{t};
  estimate.sigma = sigma;
  return estimate;
}

// A tracker and a clock that the test advances.
struct Followed {
  ManualClock clock{Utc{}};
  TurbidityTracker tracker;
  explicit Followed(TrackerLimits options = {}) : tracker(options) {}
  Verdict observe(const TurbidityEstimate& e) { return tracker.observe(e, clock.now()); }
  TrackedAir now() const { return *tracker.at(clock.now()); }
};

TEST(TurbidityTracker, KnowsNothingBeforeTheFirstEstimate) {
  Followed rig;
  EXPECT_FALSE(rig.tracker.at(rig.clock.now()));
  EXPECT_EQ(rig.observe({}), Verdict::unusable);
  EXPECT_FALSE(rig.tracker.at(rig.clock.now()));
}

TEST(TurbidityTracker, ShowsTheFirstEstimateAtOnce) {
  Followed rig;
  EXPECT_EQ(rig.observe(seen_t(4.0, 0.1)), Verdict::taken);
  EXPECT_NEAR(rig.now().air.turbidity().value, 4.0, 1e-12);
  EXPECT_NEAR(rig.now().sigma_turbidity, 0.1, 1e-9);
  EXPECT_TRUE(rig.now().trustworthy);
}

TEST(TurbidityTracker, SaysWhatKindOfAirItIs) {
  Followed rig;
  rig.observe(seen_t(4.0, 0.1));
  EXPECT_EQ(rig.now().air, AirState(Turbidity{rig.now().air.turbidity()})) << "T alone";
  EXPECT_TRUE(rig.now().seen());
  TrackerLimits known;
  known.like = Aerosol{0.0, 0.2, AerosolKind::dust};
  Followed dust(known);
  dust.observe(seen_t(4.0, 0.1));
  EXPECT_TRUE(dust.now().air.aerosol_known());
  EXPECT_EQ(dust.now().air.aerosol().kind, AerosolKind::dust);
  EXPECT_NEAR(dust.now().air.turbidity().value, 4.0, 1e-9);
}

TEST(TurbidityTracker, AveragesNoiseButNeverClaimsToBeMuchSurerThanOneLook) {
  Followed rig;
  for (std::uint64_t i = 0; i < 200; ++i) {
    rig.observe(seen_t(3.0 + 0.05 * test::hashed_normal(1, i), 0.05));
    rig.clock.advance(10s);
  }
  EXPECT_NEAR(rig.now().air.turbidity().value, 3.0, 0.03);
  EXPECT_LT(rig.now().sigma_turbidity, 0.04);
  EXPECT_GT(rig.now().sigma_turbidity, 0.3 * 0.05 * 0.99);
}

// 1 % of haze is about what the eye distinguishes side by side; a frame lasts a thirtieth of a second.
TEST(TurbidityTracker, NeverMovesByMoreThanAnEyeCanSeeBetweenFrames) {
  Followed rig;
  double before = 0.0, largest = 0.0;
  for (int frame = 0; frame < 30 * 300; ++frame) {
    if (frame % 150 == 0) rig.observe(seen_t(frame < 1500 ? 2.0 : 6.0));
    rig.clock.advance(milliseconds{33});
    const double haze = rig.now().air.turbidity().value - 1.0;
    if (before > 0.0) largest = std::max(largest, std::abs(std::log(haze / before)));
    before = haze;
  }
  EXPECT_LT(largest, 0.001);
  EXPECT_GT(before, 2.0);  // and it is moving
}

TEST(TurbidityTracker, ArrivesAtAGenuineChange) {
  Followed rig;
  rig.observe(seen_t(2.0));
  std::vector<Verdict> verdicts;
  for (int i = 0; i < 60; ++i) {
    rig.clock.advance(10s);
    verdicts.push_back(rig.observe(seen_t(5.0)));
  }
  EXPECT_EQ(verdicts[0], Verdict::outlier);
  EXPECT_EQ(verdicts[1], Verdict::outlier);
  EXPECT_EQ(verdicts[2], Verdict::restarted);
  EXPECT_NEAR(rig.now().believed.turbidity().value, 5.0, 0.01);
  EXPECT_NEAR(rig.now().air.turbidity().value, 5.0, 0.05);  // ln 4 at 0.3 a minute is 4.6 minutes
}

TEST(TurbidityTracker, SigmaIncludesTheDistanceToTheTarget) {
  Followed rig;
  rig.observe(seen_t(2.0));
  for (int i = 0; i < 3; ++i) {
    rig.clock.advance(10s);
    rig.observe(seen_t(5.0));
  }
  const TrackedAir on_its_way = rig.now();
  EXPECT_LT(on_its_way.air.turbidity().value, 2.5);
  EXPECT_GT(on_its_way.sigma_turbidity, std::log(4.0) * 0.8);
}

TEST(TurbidityTracker, FollowsAirThatChangesWithinTheHourWithoutRestarting) {
  Followed rig;
  for (int i = 0; i <= 360; ++i) {  // 2 to 5 within an hour
    const double truth = 2.0 + 3.0 * i / 360.0;
    EXPECT_NE(rig.observe(seen_t(truth, 0.02)), Verdict::restarted) << i;
    EXPECT_NEAR(rig.now().air.turbidity().value, truth, 0.1) << i;
    rig.clock.advance(10s);
  }
}

TEST(TurbidityTracker, IgnoresABirdAndASingleCloud) {
  Followed rig;
  for (int i = 0; i < 20; ++i) {
    const bool bird = i == 7 || i == 13;
    EXPECT_EQ(rig.observe(seen_t(bird ? 9.0 : 3.0)), bird ? Verdict::outlier : Verdict::taken);
    EXPECT_NEAR(rig.now().air.turbidity().value, 3.0, 1e-3);
    rig.clock.advance(10s);
  }
}

TEST(TurbidityTracker, DoesNotBelieveABurstOfFramesWithTheSameBird) {
  Followed rig;
  rig.observe(seen_t(3.0));
  for (int i = 0; i < 30; ++i) {
    rig.clock.advance(100ms);
    EXPECT_EQ(rig.observe(seen_t(9.0)), Verdict::outlier);
  }
}

TEST(TurbidityTracker, DoesNotTakeDisagreeingOutliersForAChange) {
  Followed rig;
  rig.observe(seen_t(3.0));
  for (int i = 0; i < 30; ++i) {
    rig.clock.advance(10s);
    EXPECT_EQ(rig.observe(seen_t(i % 2 == 0 ? 9.0 : 15.0)), Verdict::outlier);
  }
}

TEST(TurbidityTracker, AgesHonestlyWhileNothingIsUsable) {
  Followed rig;
  rig.observe(seen_t(3.0));
  const double fresh = rig.now().sigma_turbidity;
  rig.clock.advance(1h);
  EXPECT_EQ(rig.observe({}), Verdict::unusable);
  EXPECT_EQ(rig.now().age, 1h);
  EXPECT_NEAR(rig.now().sigma_turbidity, std::hypot(fresh, 2.0 * 0.2), 1e-6);  // 0.2 of T - 1 after an hour
  EXPECT_NEAR(rig.now().air.turbidity().value, 3.0, 1e-9);
  EXPECT_TRUE(rig.now().trustworthy);
  rig.clock.advance(90min);
  EXPECT_FALSE(rig.now().trustworthy);
  EXPECT_EQ(rig.observe(seen_t(4.5)), Verdict::taken);  // after so long it is not an outlier
  EXPECT_TRUE(rig.now().trustworthy);
  EXPECT_EQ(rig.now().age, 0s);
}

TEST(TurbidityTracker, ShowsTheSameHoweverOftenItIsAsked) {
  Followed rarely, often;
  for (int i = 0; i < 40; ++i) {
    const double t = i < 5 ? 2.0 : 3.5;
    rarely.observe(seen_t(t));
    often.observe(seen_t(t));
    rarely.clock.advance(10s);
    for (int j = 0; j < 100; ++j) {
      often.clock.advance(100ms);
      often.now();
    }
    EXPECT_DOUBLE_EQ(rarely.now().air.turbidity().value, often.now().air.turbidity().value);
  }
}

TEST(TurbidityTracker, SurvivesInvalidEstimatesAndTimesThatRunBackwards) {
  Followed rig;
  rig.clock.advance(1h);
  rig.observe(seen_t(3.0));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(rig.observe(seen_t(nan)), Verdict::unusable);
  EXPECT_EQ(rig.observe(seen_t(3.0, nan)), Verdict::unusable);
  EXPECT_EQ(rig.observe(seen_t(0.5)), Verdict::unusable);
  EXPECT_EQ(rig.tracker.observe(seen_t(3.01), Instant{}), Verdict::taken);
  const auto tracked = rig.tracker.at(Instant{});
  EXPECT_EQ(tracked->age, 0s);
  EXPECT_NEAR(tracked->air.turbidity().value, 3.0, 0.02);
}

}  // namespace
}  // namespace kasumi
