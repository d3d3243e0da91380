#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "estimator/turbidity/tracker.hpp"
#include "tests/estimator/turbidity/synthetic_sky.hpp"

namespace kasumi {
namespace {

using namespace std::chrono;
using Verdict = TurbidityTracker::Verdict;

TurbidityEstimate seen(double t, double sigma = 0.02) {
  TurbidityEstimate estimate;
  estimate.usable = true;
  estimate.turbidity = Turbidity{t};
  estimate.sigma = sigma;
  return estimate;
}

// A tracker and a clock that the test advances.
struct Rig {
  ManualClock clock{Utc{}};
  TurbidityTracker tracker;
  explicit Rig(TrackerOptions options = {}) : tracker(options) {}
  Verdict observe(const TurbidityEstimate& e) { return tracker.observe(e, clock.now()); }
  TrackedTurbidity now() const { return *tracker.at(clock.now()); }
};

TEST(Tracker, KnowsNothingBeforeTheFirstEstimate) {
  Rig rig;
  EXPECT_FALSE(rig.tracker.at(rig.clock.now()));
  EXPECT_EQ(rig.observe({}), Verdict::unusable);
  EXPECT_FALSE(rig.tracker.at(rig.clock.now()));
}

TEST(Tracker, ShowsTheFirstEstimateAtOnce) {
  Rig rig;
  EXPECT_EQ(rig.observe(seen(4.0, 0.1)), Verdict::taken);
  EXPECT_NEAR(rig.now().turbidity.value, 4.0, 1e-12);
  EXPECT_NEAR(rig.now().sigma, 0.1, 1e-9);
  EXPECT_TRUE(rig.now().trustworthy);
}

TEST(Tracker, AveragesNoiseButNeverClaimsToBeMuchSurerThanOneLook) {
  Rig rig;
  for (std::uint64_t i = 0; i < 200; ++i) {
    rig.observe(seen(3.0 + 0.05 * test::hashed_normal(1, i), 0.05));
    rig.clock.advance(10s);
  }
  EXPECT_NEAR(rig.now().turbidity.value, 3.0, 0.03);
  EXPECT_LT(rig.now().sigma, 0.04);
  EXPECT_GT(rig.now().sigma, 0.3 * 0.05 * 0.99);
}

// 1 % of haze is about what the eye distinguishes side by side; a frame lasts a thirtieth of a second.
TEST(Tracker, NeverMovesByMoreThanAnEyeCanSeeBetweenFrames) {
  Rig rig;
  double before = 0.0, largest = 0.0;
  for (int frame = 0; frame < 30 * 300; ++frame) {
    if (frame % 150 == 0) rig.observe(seen(frame < 1500 ? 2.0 : 6.0));
    rig.clock.advance(milliseconds{33});
    const double haze = rig.now().turbidity.value - 1.0;
    if (before > 0.0) largest = std::max(largest, std::abs(std::log(haze / before)));
    before = haze;
  }
  EXPECT_LT(largest, 0.001);
  EXPECT_GT(before, 2.0);  // and it is moving
}

TEST(Tracker, ArrivesAtAGenuineChange) {
  Rig rig;
  rig.observe(seen(2.0));
  std::vector<Verdict> verdicts;
  for (int i = 0; i < 60; ++i) {
    rig.clock.advance(10s);
    verdicts.push_back(rig.observe(seen(5.0)));
  }
  EXPECT_EQ(verdicts[0], Verdict::outlier);
  EXPECT_EQ(verdicts[1], Verdict::outlier);
  EXPECT_EQ(verdicts[2], Verdict::restarted);
  EXPECT_NEAR(rig.now().target.value, 5.0, 0.01);
  EXPECT_NEAR(rig.now().turbidity.value, 5.0, 0.05);  // ln 4 at 0.3 a minute is 4.6 minutes
}

TEST(Tracker, SigmaIncludesTheDistanceToTheTarget) {
  Rig rig;
  rig.observe(seen(2.0));
  for (int i = 0; i < 3; ++i) {
    rig.clock.advance(10s);
    rig.observe(seen(5.0));
  }
  const TrackedTurbidity on_its_way = rig.now();
  EXPECT_LT(on_its_way.turbidity.value, 2.5);
  EXPECT_GT(on_its_way.sigma, std::log(4.0) * 0.8);
}

TEST(Tracker, FollowsAirThatChangesWithinTheHourWithoutRestarting) {
  Rig rig;
  for (int i = 0; i <= 360; ++i) {  // 2 to 5 within an hour
    const double truth = 2.0 + 3.0 * i / 360.0;
    EXPECT_NE(rig.observe(seen(truth, 0.02)), Verdict::restarted) << i;
    EXPECT_NEAR(rig.now().turbidity.value, truth, 0.1) << i;
    rig.clock.advance(10s);
  }
}

TEST(Tracker, IgnoresABirdAndASingleCloud) {
  Rig rig;
  for (int i = 0; i < 20; ++i) {
    const bool bird = i == 7 || i == 13;
    EXPECT_EQ(rig.observe(seen(bird ? 9.0 : 3.0)), bird ? Verdict::outlier : Verdict::taken);
    EXPECT_NEAR(rig.now().turbidity.value, 3.0, 1e-3);
    rig.clock.advance(10s);
  }
}

TEST(Tracker, DoesNotBelieveABurstOfFramesWithTheSameBird) {
  Rig rig;
  rig.observe(seen(3.0));
  for (int i = 0; i < 30; ++i) {
    rig.clock.advance(100ms);
    EXPECT_EQ(rig.observe(seen(9.0)), Verdict::outlier);
  }
}

TEST(Tracker, DoesNotTakeDisagreeingOutliersForAChange) {
  Rig rig;
  rig.observe(seen(3.0));
  for (int i = 0; i < 30; ++i) {
    rig.clock.advance(10s);
    EXPECT_EQ(rig.observe(seen(i % 2 == 0 ? 9.0 : 15.0)), Verdict::outlier);
  }
}

TEST(Tracker, AgesHonestlyWhileNothingIsUsable) {
  Rig rig;
  rig.observe(seen(3.0));
  const double fresh = rig.now().sigma;
  rig.clock.advance(1h);
  EXPECT_EQ(rig.observe({}), Verdict::unusable);
  EXPECT_EQ(rig.now().age, 1h);
  EXPECT_NEAR(rig.now().sigma, std::hypot(fresh, 2.0 * 0.2), 1e-6);  // 0.2 of T - 1 after an hour
  EXPECT_NEAR(rig.now().turbidity.value, 3.0, 1e-9);
  EXPECT_TRUE(rig.now().trustworthy);
  rig.clock.advance(90min);
  EXPECT_FALSE(rig.now().trustworthy);
  EXPECT_EQ(rig.observe(seen(4.5)), Verdict::taken);  // after so long it is not an outlier
  EXPECT_TRUE(rig.now().trustworthy);
  EXPECT_EQ(rig.now().age, 0s);
}

TEST(Tracker, ShowsTheSameHoweverOftenItIsAsked) {
  Rig rarely, often;
  for (int i = 0; i < 40; ++i) {
    const double t = i < 5 ? 2.0 : 3.5;
    rarely.observe(seen(t));
    often.observe(seen(t));
    rarely.clock.advance(10s);
    for (int j = 0; j < 100; ++j) {
      often.clock.advance(100ms);
      often.now();
    }
    EXPECT_DOUBLE_EQ(rarely.now().turbidity.value, often.now().turbidity.value);
  }
}

TEST(Tracker, SurvivesInvalidEstimatesAndTimesThatRunBackwards) {
  Rig rig;
  rig.clock.advance(1h);
  rig.observe(seen(3.0));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(rig.observe(seen(nan)), Verdict::unusable);
  EXPECT_EQ(rig.observe(seen(3.0, nan)), Verdict::unusable);
  EXPECT_EQ(rig.observe(seen(0.5)), Verdict::unusable);
  EXPECT_EQ(rig.tracker.observe(seen(3.01), Instant{}), Verdict::taken);
  const auto tracked = rig.tracker.at(Instant{});
  EXPECT_EQ(tracked->age, 0s);
  EXPECT_NEAR(tracked->turbidity.value, 3.0, 0.02);
}

}  // namespace
}  // namespace kasumi
