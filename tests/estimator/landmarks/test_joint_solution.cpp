// Landmarks and airs solved together, from readings drawn by Koschmieder's law with known constants.
#include <algorithm>
#include <cmath>
#include <optional>

#include <gtest/gtest.h>

#include "base/statistics.hpp"
#include "estimator/landmarks/channel_extinctions.hpp"
#include "fixtures/noise/random.hpp"

namespace kasumi {
namespace {

constexpr double kRayleigh_per_m = 1.16e-5;

struct Facade {
  double distance_m, contrast, infinity = 1.0;  // its light from infinity over that of the sky beside it
};
const std::vector<Facade> kTowers{{2200, 0.97}, {2340, 0.95},       {2440, 1.0},        {2475, 0.93},
                                  {2690, 0.86}, {2860, 0.99, 0.98}, {4640, 0.91, 1.02}, {4685, 0.97}};

std::vector<ContrastLandmark> landmarks_of(const std::vector<Facade>& facades) {
  std::vector<ContrastLandmark> landmarks;
  for (const auto& facade : facades) {
    ContrastLandmark landmark;
    landmark.distance_m = facade.distance_m;
    landmarks.push_back(landmark);
  }
  return landmarks;
}

double koschmieder(const Facade& facade, double per_m) {
  const double floor = 1.0 - facade.infinity;
  return floor + (facade.contrast - floor) * std::exp(-per_m * facade.distance_m);
}

ContrastReading read_as(double contrast) {
  return {true, "", glm::dvec3(contrast), glm::dvec3(0.006)};
}

// One facade in eight is in the sun.
std::vector<ContrastReading> picture(const std::vector<Facade>& facades, double per_m, fixtures::Random& random) {
  std::vector<ContrastReading> readings;
  for (const auto& facade : facades) {
    const double left = std::exp(-per_m * facade.distance_m);
    const double lit = random.uniform() < 0.125 ? 0.5 * random.uniform() : 0.01 * random.normal();
    readings.push_back(read_as(koschmieder(facade, per_m) - lit * left + 0.006 * random.normal()));
  }
  return readings;
}

double hazy_per_m(fixtures::Random& random) {
  return kRayleigh_per_m + 6e-5 * std::exp(0.7 * random.normal());
}

// A hundred and fifty pictures make an answer no smaller than twenty do, and no surer than it is.
TEST(JointSolution, DoesNotForgetTheHazeByLearning) {
  const LandmarkWatch watch(Camera{}, 0.0, landmarks_of(kTowers), {}, ScatteringModel::aerosol);
  std::vector<double> ratios;
  for (const int count : {20, 150}) {
    fixtures::Random random(17);
    std::vector<double> truth, ratio;
    std::vector<std::vector<ContrastReading>> pictures;
    for (int t = 0; t < count; ++t) {
      truth.push_back(hazy_per_m(random));
      pictures.push_back(picture(kTowers, truth.back(), random));
    }
    const auto airs = watch.estimate_all(pictures);
    int values = 0, within = 0, contradicted = 0;
    for (std::size_t t = 0; t < airs.size(); ++t) {
      const auto& found = airs[t].extinction();
      ratio.push_back(found.per_m / truth[t]);
      if (found.kind == ExtinctionKind::value)
        ++values, within += std::abs(found.per_m - truth[t]) <= found.sigma_per_m;
      if (found.kind == ExtinctionKind::at_most) contradicted += truth[t] > found.highest_per_m;
      if (found.kind == ExtinctionKind::at_least) contradicted += truth[t] < found.lowest_per_m;
    }
    ratios.push_back(median(ratio));
    EXPECT_NEAR(ratios.back(), 1.0, 0.12) << count << " pictures";
    EXPECT_GE(values, 0.85 * count);
    EXPECT_GT(within, 0.5 * values) << count;
    EXPECT_LE(contradicted, 0.04 * count);
  }
  const auto [least, most] = std::ranges::minmax(ratios);
  EXPECT_LT(most / least, 1.1);
}

// Where fog hides all, what is left of the contrast is the light from infinity's: .6 of the sky's at one of them.
TEST(JointSolution, LearnsTheLightFromInfinityWhereLandmarksAreGone) {
  const std::vector<Facade> hill{{380, 0.95, 0.85}, {290, 0.95, 0.6}, {255, 0.97, 0.95}};
  auto landmarks = landmarks_of(hill);
  for (auto& one : landmarks) one.infinity_sigma = 0.2;
  const LandmarkWatch watch(Camera{}, 0.0, landmarks, {}, ScatteringModel::aerosol);
  fixtures::Random random(3);
  std::vector<double> truth;
  std::vector<std::vector<ContrastReading>> pictures;
  for (int t = 0; t < 60; ++t) {
    truth.push_back(1e-4 * std::exp(std::log(300.0) * (t % 20) / 19.0));
    pictures.push_back(picture(hill, truth.back(), random));
  }
  const auto airs = watch.estimate_all(pictures);
  std::vector<double> off;
  for (std::size_t t = 0; t < airs.size(); ++t)
    if (truth[t] > 1e-3 && truth[t] < 1e-2) off.push_back(std::log(airs[t].extinction().per_m / truth[t]));
  EXPECT_NEAR(median(off), 0.0, 0.15) << "fog that hides half and more";
}

TEST(JointSolution, WhatIsLeftOutTakesNoPart) {
  const LandmarkWatch watch(Camera{}, 0.0, landmarks_of(kTowers), {}, ScatteringModel::aerosol);
  fixtures::Random random(5);
  std::vector<std::vector<ContrastReading>> pictures;
  for (int t = 0; t < 12; ++t) pictures.push_back(picture(kTowers, hazy_per_m(random), random));
  const std::vector<std::size_t> out{2, 7};
  const auto before = watch.estimate_all(pictures, out);
  for (auto& readings : pictures) readings[2] = readings[7] = read_as(0.1);
  const auto after = watch.estimate_all(pictures, out);
  for (std::size_t t = 0; t < pictures.size(); ++t) {
    EXPECT_EQ(before[t].extinction().per_m, after[t].extinction().per_m);
    EXPECT_LE(after[t].extinction().landmarks, 6);
  }
}

TEST(JointSolution, PicturesThatShowNothingAreNoHours) {
  const LandmarkWatch watch(Camera{}, 0.0, landmarks_of(kTowers), {}, ScatteringModel::aerosol);
  fixtures::Random random(5);
  std::vector<std::vector<ContrastReading>> pictures, with_nights;
  for (int t = 0; t < 9; ++t) {
    pictures.push_back(picture(kTowers, hazy_per_m(random), random));
    with_nights.push_back(pictures.back());
    with_nights.emplace_back(kTowers.size(), ContrastReading{false, "by night", {}, {}});
  }
  const auto by_day = watch.estimate_all(pictures), by_all = watch.estimate_all(with_nights);
  for (std::size_t t = 0; t < pictures.size(); ++t)
    EXPECT_NEAR(by_all[2 * t].extinction().per_m / by_day[t].extinction().per_m, 1.0, 1e-6) << t;
}

constexpr double kAerosol_per_m = 3e-4;
// Surfaces of known colour, as a path of that aerosol shows them. `sunlight`: of the horizon's light that they return
// more than in the shade, one by a third of it more, the next by a third less.
PathAerosol aerosol_seen(double exponent, const glm::dvec3& sunlight = glm::dvec3{0.0},
                         std::optional<Radians> faces = {}) {
  std::vector<ContrastLandmark> landmarks = landmarks_of(kTowers);
  for (auto& landmark : landmarks) landmark.faces = faces;
  const LandmarkColours colours(Camera{}, landmarks, 0.0);
  std::vector<ContrastReading> readings;
  for (const auto& landmark : landmarks) {
    ContrastReading reading{true, "", {}, glm::dvec3(0.003)};
    const double share = readings.size() % 2 == 0 ? 4.0 / 3.0 : 2.0 / 3.0;
    for (int c = 0; c < 3; ++c) {
      const double nm = colours.wavelength_nm()[c];
      const double per_m =
          rayleigh_per_m(ScatteringModel::aerosol, nm, 0.0) + kAerosol_per_m * std::pow(nm / 550.0, -exponent);
      reading.contrast[c] =
          (1.0 - 0.06 * ColourSpread{}.dull[c] - share * sunlight[c]) * std::exp(-per_m * haze_path_m(landmark, 0.0));
    }
    readings.push_back(reading);
  }
  return colours.estimate(readings);
}

// Dust's lies near the end of what is believed and is found; one that no aerosol has is not.
TEST(JointSolution, AnExponentThatNoAerosolHasIsUnknown) {
  for (const double exponent : {-0.2, 0.1, 1.3, 2.0}) {
    const auto seen = aerosol_seen(exponent);
    EXPECT_TRUE(seen.exponent_told) << exponent;
    EXPECT_NEAR(seen.angstrom_exponent, exponent, std::max(0.15, std::sqrt(seen.covariance.exponent))) << exponent;
  }
  for (const double exponent : {-2.0, 4.0}) {
    const auto seen = aerosol_seen(exponent);
    EXPECT_FALSE(seen.exponent_told) << exponent;
    EXPECT_NEAR(seen.angstrom_exponent, 1.3, 1e-9) << "as usual";
    EXPECT_NEAR(std::sqrt(seen.covariance.exponent), 0.5, 1e-9);
  }
}

// Grassland in the sun: .10, .10, .05 reflected (R, G, B) of 2.5, 2.4, 1.5 times the horizon's light.
TEST(JointSolution, SunlitLandOfWhichNothingIsSaidTellsNoLowExponentSurely) {
  const glm::dvec3 grassland{0.25, 0.24, 0.075};
  for (const double exponent : {0.5, 1.3, 1.8}) {
    const auto seen = aerosol_seen(exponent, grassland), shaded = aerosol_seen(exponent, grassland, from_degrees(0.0));
    EXPECT_TRUE(seen.exponent_told) << exponent;
    const double off = std::abs(seen.angstrom_exponent - exponent) / std::sqrt(seen.covariance.exponent);
    EXPECT_LT(off, 2.0) << exponent;
    EXPECT_LT(std::abs(seen.per_m - kAerosol_per_m), 2.0 * std::sqrt(seen.covariance.per_m)) << exponent;
    const double off_as_shaded = std::abs(shaded.angstrom_exponent - exponent) / std::sqrt(shaded.covariance.exponent);
    EXPECT_GT(off_as_shaded, 1.3 * off) << exponent << ": of facades that are said to be in the shade";
  }
  const auto facades = aerosol_seen(1.3), known = aerosol_seen(1.3, glm::dvec3{0.0}, from_degrees(0.0));
  EXPECT_LT(known.covariance.exponent, facades.covariance.exponent) << "known to be in the shade";
}

TEST(JointSolution, AnUnchangedSceneIsOneReading) {
  LandmarkWatch watch(Camera{}, 0.0, landmarks_of(kTowers), {}, ScatteringModel::aerosol);
  fixtures::Random random(5);
  const auto readings = picture(kTowers, 5e-5, random);
  for (int i = 0; i < 10; ++i) watch.learn(readings, 0.1 * i);
  EXPECT_EQ(watch.kept().size(), 1U);
  std::vector<KeptReadings> kept;
  for (int i = 0; i < 199; ++i) kept.push_back({picture(kTowers, hazy_per_m(random), random), 0.02 * i});
  ASSERT_TRUE(watch.resume(kept));
  for (int i = 0; i < 3; ++i) watch.learn(picture(kTowers, hazy_per_m(random), random), 4.0 + 0.02 * i);
  EXPECT_EQ(watch.kept().size(), LandmarkWatch::kMostKept);
  LandmarkWatch other(Camera{}, 0.0, landmarks_of(kTowers), {}, ScatteringModel::aerosol);
  ASSERT_TRUE(other.resume(watch.kept()));
  EXPECT_NEAR(other.estimate(readings).extinction().per_m / watch.estimate(readings).extinction().per_m, 1.0, 0.03);
  const LandmarkWatch few(Camera{}, 0.0, landmarks_of({kTowers[0]}), {}, ScatteringModel::aerosol);
  EXPECT_FALSE(LandmarkWatch(few).resume(watch.kept())) << "of other landmarks";
}

// Extinction that grows with wavelength is no air: 1.59, .99, .73 per km of a lone tower in warm sunlight.
TEST(JointSolution, ALitLandmarkIsNoDarkOne) {
  const LandmarkWatch watch(Camera{}, 0.0, landmarks_of({{1000, 0.94}}), {}, ScatteringModel::aerosol);
  auto reading = read_as(0.0);
  reading.contrast = 0.94 * glm::dvec3(std::exp(-1.59), std::exp(-0.99), std::exp(-0.73));
  const auto lit = watch.estimate({reading});
  EXPECT_EQ(lit.extinction().kind, ExtinctionKind::at_most) << "haze may be the less";
  EXPECT_NE(lit.extinction().reason.find("in the sun"), std::string::npos);
  reading.contrast = 0.94 * glm::dvec3(std::exp(-0.73), std::exp(-0.99), std::exp(-1.59));
  EXPECT_EQ(watch.estimate({reading}).extinction().kind, ExtinctionKind::value);
}

TEST(JointSolution, AFacadeTowardsTheSunIsLit) {
  auto landmarks = landmarks_of({kTowers[0], kTowers[1]});
  landmarks[0].faces = from_degrees(90.0);
  std::vector<ContrastReading> readings{read_as(0.5), read_as(0.5)};
  mark_lit(landmarks, direction_from(from_degrees(60.0), from_degrees(240.0)), readings);
  EXPECT_FALSE(readings[0].lit) << "the sun is behind it";
  mark_lit(landmarks, direction_from(from_degrees(60.0), from_degrees(120.0)), readings);
  EXPECT_TRUE(readings[0].lit);
  EXPECT_FALSE(readings[1].lit) << "nobody says where it looks";
}

// A tower in the sun before a rain cloud.
TEST(JointSolution, ASkyThatIsDarkerThanTheLandIsNoLightFromInfinity) {
  const auto landmarks = landmarks_of(kTowers);
  const LandmarkWatch watch(Camera{}, 0.0, landmarks, {}, ScatteringModel::aerosol);
  fixtures::Random random(5);
  auto readings = picture(kTowers, 5e-5, random);
  readings[1] = read_as(-0.4);
  EXPECT_EQ(watch.estimate(readings).extinction().kind, ExtinctionKind::value) << "one alone may be anything";
  readings[4] = read_as(-0.6);
  const auto air = watch.estimate(readings);
  EXPECT_EQ(air.extinction().kind, ExtinctionKind::nothing);
  EXPECT_NE(air.extinction().reason.find("no light from infinity"), std::string::npos);
}

TEST(JointSolution, NearAndFarThatDoNotAgreeAreToldAndLessSure) {
  const LandmarkWatch watch(Camera{}, 0.0, landmarks_of(kTowers), {}, ScatteringModel::aerosol);
  std::vector<ContrastReading> readings, torn;
  for (const auto& tower : kTowers) {
    readings.push_back(read_as(koschmieder(tower, 2e-4)));
    torn.push_back(read_as(koschmieder(tower, tower.distance_m > 4000.0 ? 1.2e-4 : 2.6e-4)));
  }
  const auto one = watch.estimate(readings), two = watch.estimate(torn);
  EXPECT_EQ(one.doubt, "");
  EXPECT_NE(two.doubt.find("near landmarks say"), std::string::npos);
  EXPECT_GT(two.extinction().sigma_per_m / two.extinction().per_m,
            1.5 * one.extinction().sigma_per_m / one.extinction().per_m);
}

}  // namespace
}  // namespace kasumi
