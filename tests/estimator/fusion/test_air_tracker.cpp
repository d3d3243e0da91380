#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "tests/estimator/fusion/simulated_weather.hpp"

namespace kasumi {
namespace {

using namespace std::chrono;
using test::column_reading;
using test::path_reading;
using Verdict = AirTracker::Verdict;
using Kind = PathReading::Channel::Kind;

// A tracker and a clock that the test advances.
struct Rig {
  Instant now{};
  AirTracker tracker;
  explicit Rig(TrackingRules options = {}) : tracker(std::move(options)) {}

  Verdict sky(double aod, double sigma = 0.01, double exponent = 1.3) {
    return tracker.observe(column_reading(aod, sigma, exponent, 0.1), now);
  }
  Verdict landmarks(double path_aod, double sigma = 0.05) {
    return tracker.observe(path_reading(path_aod, 1.3, sigma, 0.1), now);
  }
  // All three channels bound.
  Verdict bound(double path_aod, Kind kind, double sigma = 0.1) {
    PathReading reading = path_reading(path_aod, 1.3, sigma, 0.0);
    for (auto& channel : reading.channels) channel.kind = kind;
    return tracker.observe(reading, now);
  }
  TrackedAir air() const { return tracker.at(now); }
  double believed() const { return air().believed.aerosol().aod_550; }
  double believed_path() const { return believed() * air().believed.near_ground(); }
};

const ObserverPart* part(const TrackedAir& air, AirObserver by) {
  for (const auto& one : air.observers)
    if (one.by == by) return &one;
  return nullptr;
}

TEST(AirTracker, SupposesTheAirUntilSomebodyHasSeenIt) {
  Rig rig;
  EXPECT_TRUE(rig.air().supposed);
  EXPECT_FALSE(rig.air().trustworthy);
  EXPECT_NEAR(rig.believed(), 0.15, 1e-9);
  EXPECT_EQ(rig.air().air.near_ground(), 1.0);
  EXPECT_NEAR(std::sqrt(rig.air().believed.covariance().aod_550), 0.1, 0.02);
  EXPECT_EQ(rig.air().text(), "the air is supposed: aerosol 0.15, T 2.5");
  EXPECT_FALSE(rig.tracker.to_remember(rig.now, Utc{}));
}

TEST(AirTracker, ShowsTheFirstReadingAtOnce) {
  Rig rig;
  EXPECT_EQ(rig.sky(0.6, 0.03), Verdict::taken);
  EXPECT_FALSE(rig.air().supposed);
  EXPECT_TRUE(rig.air().trustworthy);
  EXPECT_NEAR(rig.air().air.aerosol().aod_550, 0.6, 0.01);
  EXPECT_NEAR(std::sqrt(rig.air().air.covariance().aod_550), 0.03, 0.003);
  EXPECT_EQ(rig.air().air, rig.air().believed);
  EXPECT_EQ(rig.air().text(), "aerosol 0.60 +- 0.03 by sky");
}

TEST(AirTracker, RefusesImpossibleReadings) {
  Rig rig;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(rig.sky(0.1, nan), Verdict::unusable);
  EXPECT_EQ(rig.sky(0.1, 0.01, nan), Verdict::unusable);
  EXPECT_EQ(rig.landmarks(nan), Verdict::unusable);
  EXPECT_EQ(rig.tracker.observe(PathReading{}, rig.now), Verdict::unusable);
  EXPECT_TRUE(rig.air().supposed);
}

TEST(AirTracker, ManyPicturesOfOneObserverAreHardlySurerThanOne) {
  Rig rig;
  for (int i = 0; i < 2000; ++i) {
    rig.sky(0.2, 0.02);
    rig.now += 5s;
  }
  EXPECT_GT(std::sqrt(rig.air().believed.covariance().aod_550), 0.015);
  EXPECT_LT(std::sqrt(rig.air().believed.covariance().aod_550), 0.025);
}

TEST(AirTracker, TwoObserversAreSurerThanOne) {
  Rig one, both;
  one.landmarks(0.2, 0.1);
  both.landmarks(0.2, 0.1);
  both.sky(0.2, 0.02);
  EXPECT_LT(both.air().sigma_log_path_amount, one.air().sigma_log_path_amount);
  EXPECT_LT(both.air().believed.covariance().aod_550, 0.5 * one.air().believed.covariance().aod_550);
}

TEST(AirTracker, TheFinerReadingCountsForMore) {
  Rig rig;
  rig.sky(0.2, 0.01);
  rig.tracker.observe(column_reading(0.3, 0.1, 1.3, 0.5, AirObserver::horizon), rig.now);
  EXPECT_NEAR(rig.believed(), 0.2, 0.01);
  EXPECT_GT(part(rig.air(), AirObserver::sky)->share, part(rig.air(), AirObserver::horizon)->share);
  EXPECT_NEAR(part(rig.air(), AirObserver::horizon)->apart_sigmas, 1.0, 0.4);
}

TEST(AirTracker, NeverMovesByMoreThanAnEyeCanSeeBetweenFrames) {
  Rig rig;
  double before = 0.0, before_path = 0.0, largest = 0.0;
  for (int frame = 0; frame < 30 * 300; ++frame) {
    if (frame % 150 == 0) rig.sky(frame < 1500 ? 0.1 : 0.5);
    if (frame % 1800 == 1750) rig.landmarks(frame < 1500 ? 0.1 : 1.0);
    rig.now += milliseconds(33);
    const AirState air = rig.air().air;
    const double haze = std::log(air.aerosol().aod_550 + kSmallAerosol);
    const double path = std::log(air.aerosol().aod_550 * air.near_ground() + kSmallAerosol);
    if (frame > 0) largest = std::max({largest, std::abs(haze - before), std::abs(path - before_path)});
    before = haze;
    before_path = path;
  }
  EXPECT_LT(largest, 0.001);
  EXPECT_GT(before, std::log(0.3));  // and it is moving
}

TEST(AirTracker, WhatIsShownDoesNotDependOnHowOftenItIsAsked) {
  Rig often, once;
  for (Rig* rig : {&often, &once}) rig->sky(0.1), rig->now += 60s, rig->sky(0.14);
  for (int i = 0; i < 60; ++i) {
    often.now += 1s;
    (void)often.air();
  }
  once.now += 60s;
  EXPECT_EQ(often.air().air, once.air().air);
}

TEST(AirTracker, ABirdIsIgnoredAndAFrontFollowed) {
  Rig rig;
  rig.sky(0.1);
  rig.now += 10s;
  EXPECT_EQ(rig.sky(1.0), Verdict::outlier);
  rig.now += 10s;
  EXPECT_EQ(rig.sky(0.1), Verdict::taken);
  EXPECT_NEAR(rig.believed(), 0.1, 0.005);
  std::vector<Verdict> verdicts;
  for (int i = 0; i < 40; ++i) {
    rig.now += 10s;
    verdicts.push_back(rig.sky(0.8, 0.02));
  }
  EXPECT_EQ(verdicts[0], Verdict::outlier);
  EXPECT_EQ(verdicts[1], Verdict::outlier);
  EXPECT_EQ(verdicts[2], Verdict::restarted);
  EXPECT_NEAR(rig.believed(), 0.8, 0.03);
  rig.now += 10min;
  EXPECT_NEAR(rig.air().air.aerosol().aod_550, 0.8, 0.03);
}

TEST(AirTracker, ABurstOfFramesWithTheSameBirdIsNoFront) {
  Rig rig;
  rig.sky(0.1);
  for (int i = 0; i < 20; ++i) {
    rig.now += 500ms;
    EXPECT_EQ(rig.sky(1.0), Verdict::outlier);
  }
}

TEST(AirTracker, AirThatChangesWithinTheHourIsFollowedWithoutDoubt) {
  Rig rig;
  double worst = 0.0;
  for (int i = 0; i <= 360; ++i) {
    const double truth = 0.1 + 0.3 * i / 360.0;
    EXPECT_EQ(rig.sky(truth, 0.01), Verdict::taken) << i;
    worst = std::max(worst, std::abs(rig.believed() - truth));
    rig.now += 10s;
  }
  std::printf("aerosol .1 to .4 within an hour: it lags by %.4f at most\n", worst);
  EXPECT_LT(worst, 0.01);
}

TEST(AirTracker, FogOnThePathAloneIsNotTheColumns) {
  Rig rig;
  for (int minute = 0; minute < 60; ++minute) {
    rig.sky(0.12);
    rig.landmarks(0.15);
    rig.now += 60s;
  }
  EXPECT_NEAR(rig.air().believed.near_ground(), 1.25, 0.12);
  for (int minute = 0; minute < 20; ++minute) {
    rig.sky(0.12);
    rig.landmarks(2.0);
    rig.now += 60s;
  }
  EXPECT_NEAR(rig.believed(), 0.12, 0.01);
  EXPECT_NEAR(rig.believed_path(), 2.0, 0.2);
  EXPECT_NEAR(rig.air().air.aerosol().aod_550, 0.12, 0.01);  // nor was it shown in between
}

TEST(AirTracker, FogThatComesWhileTheSkyIsAwayForAMomentIsNotTheColumns) {
  Rig rig;
  for (int minute = 0; minute < 60; ++minute) {
    rig.sky(0.12);
    rig.landmarks(0.12);
    rig.now += 60s;
  }
  for (int minute = 0; minute < 5; ++minute) {
    rig.landmarks(2.0);
    rig.now += 60s;
  }
  EXPECT_NEAR(rig.believed_path(), 2.0, 0.25);
  EXPECT_NEAR(rig.believed(), 0.12, 0.04);
}

TEST(AirTracker, OneColumnObserverThatContradictsASurerOneErrsItself) {
  Rig rig;
  double lowest = 1.0, highest = 0.0;
  for (int i = 0; i < 720; ++i) {
    rig.sky(0.1, 0.005);
    if (i % 12 == 0) rig.tracker.observe(column_reading(0.6, 0.06, 1.3, 0.4, AirObserver::horizon), rig.now);
    lowest = std::min(lowest, rig.believed());
    highest = std::max(highest, rig.believed());
    rig.now += 5s;
  }
  EXPECT_GT(lowest, 0.09);
  EXPECT_LT(highest, 0.12);
  EXPECT_GT(part(rig.air(), AirObserver::horizon)->apart_sigmas, 4.0);
}

TEST(AirTracker, LandmarksCarryTheAirUnderClouds) {
  Rig rig;
  for (int minute = 0; minute < 120; ++minute) {
    rig.sky(0.12);
    rig.landmarks(0.24);
    rig.now += 60s;
  }
  const double sigma_before = std::sqrt(rig.air().believed.covariance().aod_550);
  // The sky goes; the haze doubles within four hours. Path and column had differed by a factor of two, and still do.
  for (int minute = 0; minute < 240; ++minute) {
    rig.landmarks(0.24 * std::pow(2.0, minute / 240.0));
    rig.now += 60s;
  }
  const TrackedAir air = rig.air();
  EXPECT_FALSE(air.supposed);
  EXPECT_NEAR(rig.believed_path(), 0.48, 0.05);
  EXPECT_NEAR(rig.believed(), 0.24, 0.05);
  EXPECT_GT(std::sqrt(air.believed.covariance().aod_550), 1.5 * sigma_before);
  EXPECT_GT(part(air, AirObserver::landmarks)->share, 0.8);
  EXPECT_EQ(part(air, AirObserver::sky)->age, 241min);
  EXPECT_EQ(air.age, 1min);
}

TEST(AirTracker, WithoutAnyObserverSigmaGrowsUntilTheAirIsSupposed) {
  Rig rig;
  rig.sky(0.5, 0.02);
  double before = 0.0;
  for (int hour = 0; hour < 48; ++hour) {
    const double sigma = std::sqrt(rig.air().believed.covariance().aod_550) / (rig.believed() + kSmallAerosol);
    EXPECT_GT(sigma, before) << hour;
    before = sigma;
    if (hour == 1) {
      EXPECT_NEAR(sigma, 0.2, 0.02);
    }
    EXPECT_EQ(rig.air().trustworthy, hour <= 2) << hour;
    if (hour <= 6 || hour >= 9) {
      EXPECT_EQ(rig.air().supposed, hour >= 9) << hour;
    }
    rig.now += 1h;
  }
  EXPECT_NEAR(rig.believed(), 0.15, 0.03);
  rig.sky(0.3);
  EXPECT_FALSE(rig.air().supposed);
}

TEST(AirTracker, ABoundNarrowsOneSideOnly) {
  Rig clear, hazy, empty;
  clear.bound(0.05, Kind::at_most);
  hazy.bound(0.5, Kind::at_least);
  // Half of what usual air is, and as sure as it is that far from its middle.
  EXPECT_LT(clear.believed_path(), 0.05);
  EXPECT_GT(clear.believed_path(), 0.01);
  EXPECT_GT(clear.air().sigma_log_path_amount, 0.2);
  EXPECT_LT(clear.air().sigma_log_path_amount, 0.6);
  EXPECT_GT(hazy.believed_path(), 0.5);
  EXPECT_LT(hazy.believed_path(), 1.2);
  EXPECT_LT(hazy.believed(), hazy.believed_path());  // a part of it is the path's alone
  EXPECT_EQ(clear.bound(0.05, Kind::at_most), Verdict::taken);
}

TEST(AirTracker, ABoundThatHoldsAnywaySaysNothing) {
  Rig rig;
  rig.sky(0.1, 0.005);
  for (int i = 0; i < 10; ++i) rig.landmarks(0.1);
  const TrackedAir before = rig.air();
  EXPECT_EQ(rig.bound(1.0, Kind::at_most), Verdict::taken);
  EXPECT_EQ(rig.bound(0.02, Kind::at_least), Verdict::taken);
  EXPECT_NEAR(rig.air().believed.aerosol().aod_550, before.believed.aerosol().aod_550, 0.002);
  EXPECT_NEAR(rig.air().sigma_log_path_amount, before.sigma_log_path_amount, 0.02 * before.sigma_log_path_amount);
}

TEST(AirTracker, FogThatHidesAllLandmarksIsFollowed) {
  Rig rig;
  for (int i = 0; i < 10; ++i) {
    rig.sky(0.1);
    rig.landmarks(0.1);
    rig.now += 60s;
  }
  for (int i = 0; i < 4; ++i) {
    rig.bound(10.0, Kind::at_least);
    rig.now += 60s;
  }
  EXPECT_GT(rig.believed_path(), 8.0);
}

TEST(AirTracker, ColoursOfThePathTellTheExponent) {
  Rig rig;
  for (int i = 0; i < 5; ++i) rig.tracker.observe(path_reading(1.0, 0.1, 0.02, 0.2), rig.now);
  EXPECT_NEAR(rig.air().believed.aerosol().angstrom_exponent, 0.1, 0.25);
  EXPECT_LT(std::sqrt(rig.air().believed.covariance().angstrom_exponent), 0.25);
}

TEST(AirTracker, RemembersOverARestart) {
  Rig before;
  for (int i = 0; i < 60; ++i) {
    before.sky(0.3, 0.02, 0.6);
    before.landmarks(0.45);
    before.now += 60s;
  }
  const Utc noon{std::chrono::hours(1000)};
  const auto kept = before.tracker.to_remember(before.now, noon);
  ASSERT_TRUE(kept);
  EXPECT_EQ(kept->utc, noon - 1min);

  Rig after;
  after.tracker.remember(*kept, after.now - 1h);
  const TrackedAir air = after.air();
  EXPECT_FALSE(air.supposed);
  EXPECT_EQ(air.age, 1h);
  EXPECT_NEAR(air.air.aerosol().aod_550, before.believed(), 0.01);
  EXPECT_NEAR(air.air.aerosol().angstrom_exponent, before.air().believed.aerosol().angstrom_exponent, 0.05);
  EXPECT_NEAR(air.air.near_ground(), before.air().believed.near_ground(), 0.03);
  EXPECT_GT(air.believed.covariance().aod_550, 4.0 * before.air().believed.covariance().aod_550);
  EXPECT_EQ(air.observers.front().by, AirObserver::remembered);
  // Once there is a reading, memories have no effect.
  EXPECT_EQ(after.sky(0.28), Verdict::taken);
  const AirState seen = after.air().believed;
  after.tracker.remember(*kept, after.now);
  EXPECT_EQ(after.air().believed, seen);
}

TEST(AirTracker, WhatIsGivenStays) {
  TrackingRules whole;
  whole.given.aod_550 = 0.4;
  whole.given.kind = AerosolKind::dust;
  Rig rig(whole);
  EXPECT_FALSE(rig.air().supposed);
  rig.sky(0.1);
  rig.landmarks(0.1);
  rig.now += 60s;
  const TrackedAir air = rig.air();
  EXPECT_NEAR(air.air.aerosol().aod_550, 0.4, 1e-9);
  EXPECT_EQ(air.air.aerosol().kind, AerosolKind::dust);
  EXPECT_EQ(air.air.aerosol().angstrom_exponent, natural_exponent(AerosolKind::dust));
  EXPECT_EQ(air.air.near_ground(), 1.0);
  EXPECT_EQ(air.air.covariance(), AerosolCovariance{});
  EXPECT_LT(part(air, AirObserver::sky)->apart_sigmas, -3.0);

  TrackingRules exponent;
  exponent.given.angstrom_exponent = 0.8;
  Rig other(exponent);
  other.sky(0.1);
  EXPECT_EQ(other.air().air.aerosol().angstrom_exponent, 0.8);
  EXPECT_NEAR(other.air().air.aerosol().aod_550, 0.1, 0.01);
}

ColumnReading of_kinds(double continental, double dust, double papers = 0.0) {
  ColumnReading reading = column_reading(0.2, 0.02, 1.3, 0.2);
  reading.found.kinds = {};
  reading.found.kinds[0] = continental;
  reading.found.kinds[static_cast<std::size_t>(AerosolKind::dust)] = dust;
  reading.found.papers_share = papers;
  return reading;
}

TEST(AirTracker, TheKindDoesNotGoToAndFro) {
  Rig rig;
  rig.tracker.observe(of_kinds(0.6, 0.4), rig.now);
  int changes = 0;
  auto shown = rig.air().air.aerosol().kind;
  EXPECT_EQ(shown, AerosolKind::continental);
  for (int i = 0; i < 400; ++i) {
    rig.now += 10s;
    rig.tracker.observe(i % 2 == 0 ? of_kinds(0.45, 0.55) : of_kinds(0.55, 0.45), rig.now);
    changes += rig.air().air.aerosol().kind != shown;
    shown = rig.air().air.aerosol().kind;
  }
  EXPECT_EQ(changes, 0);
  for (int i = 0; i < 400; ++i) {
    rig.now += 10s;
    rig.tracker.observe(of_kinds(0.1, 0.9), rig.now);
  }
  EXPECT_EQ(rig.air().air.aerosol().kind, AerosolKind::dust);
  EXPECT_NEAR(rig.air().kinds[0], 0.1, 0.1);
}

TEST(AirTracker, ThePapersSkyIsLeftAndEnteredWithReluctance) {
  Rig rig;
  rig.tracker.observe(of_kinds(1, 0, 0.9), rig.now);
  EXPECT_FALSE(rig.air().air.aerosol_known());
  EXPECT_NEAR(rig.air().air.turbidity().value, turbidity_of({0.2, 1.3}), 0.02);
  for (int i = 0; i < 400; ++i) {
    rig.now += 10s;
    rig.tracker.observe(of_kinds(1, 0, i % 2 == 0 ? 0.4 : 0.6), rig.now);
    EXPECT_FALSE(rig.air().air.aerosol_known());
  }
  for (int i = 0; i < 400; ++i) {
    rig.now += 10s;
    rig.tracker.observe(of_kinds(1, 0, 0.1), rig.now);
  }
  EXPECT_TRUE(rig.air().air.aerosol_known());
}

TEST(AirTracker, TheSkyAboveKnowsTheKindBetterThanTheLowSky) {
  Rig rig;
  ColumnReading low = of_kinds(0.0, 1.0, 0.0);
  low.by = AirObserver::horizon;
  rig.tracker.observe(low, rig.now);
  EXPECT_EQ(rig.air().air.aerosol().kind, AerosolKind::dust);
  rig.tracker.observe(of_kinds(1.0, 0.0), rig.now);
  EXPECT_EQ(rig.air().air.aerosol().kind, AerosolKind::continental);
  for (int minute = 0; minute < 60; ++minute) rig.now += 1min, rig.tracker.observe(low, rig.now);
  EXPECT_EQ(rig.air().air.aerosol().kind, AerosolKind::continental);
  for (int minute = 0; minute < 180; ++minute) rig.now += 1min, rig.tracker.observe(low, rig.now);
  EXPECT_EQ(rig.air().air.aerosol().kind, AerosolKind::dust);
}

TEST(AirTracker, InThePapersAirTIsAsSureAsTheSkyThoughTheExponentIsNot) {
  Rig rig;
  ColumnReading reading = column_reading(aerosol_of(2.4).aod_550, 0.002, 1.3, 0.4);
  reading.found.papers_share = 1.0;
  rig.tracker.observe(reading, rig.now);
  rig.tracker.observe(path_reading(0.3, 0.5, 0.05, 0.1), rig.now);  // tells of another exponent
  EXPECT_NEAR(rig.air().air.turbidity().value, 2.4, 0.02);
  EXPECT_NEAR(rig.air().sigma_turbidity, 0.02, 0.005);
}

TEST(AirTracker, InThePapersAirThePathIsAsLandmarksSeeIt) {
  Rig rig;
  for (int i = 0; i < 30; ++i) {
    ColumnReading reading = column_reading(0.2, 0.01, 1.3, 0.1);
    reading.found.papers_share = 1.0;
    rig.tracker.observe(reading, rig.now);
    if (i == 0) {
      EXPECT_EQ(rig.air().air.near_ground(), 1.0);
    }
    rig.landmarks(0.5);
    rig.now += 60s;
  }
  const AirState air = rig.air().believed;
  ASSERT_FALSE(air.aerosol_known());
  const double seen = test::extinction_per_m(0.5, 1.3, 550.0);
  const double drawn =
      rayleigh_per_m(ScatteringModel::morales2017, 550.0) + mie_per_m(ScatteringModel::morales2017, 550.0, air);
  EXPECT_NEAR(drawn / seen, 1.0, 0.1);
}

}  // namespace
}  // namespace kasumi
