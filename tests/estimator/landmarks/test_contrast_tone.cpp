// A camera's tone curve by landmarks near and far that fade in haze; readings drawn by Koschmieder's law, then shown by
// a camera of known curve.
#include <chrono>
#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "estimator/landmarks/channel_extinctions.hpp"
#include "fixtures/noise/random.hpp"

namespace kasumi {
namespace {

struct FadingTower {
  double distance_m, contrast;
};
const std::vector<FadingTower> kFadingTowers{{2200, 0.97}, {2340, 0.95}, {2440, 0.99}, {2475, 0.93},
                                             {2690, 0.86}, {2860, 0.99}, {4640, 0.91}, {4685, 0.97}};

LandmarkWatch watch_of(const std::vector<FadingTower>& towers) {
  std::vector<ContrastLandmark> landmarks;
  for (const auto& tower : towers) {
    ContrastLandmark landmark;
    landmark.distance_m = tower.distance_m;
    landmarks.push_back(landmark);
  }
  return LandmarkWatch(Camera{}, 0.0, landmarks, {}, ScatteringModel::aerosol);
}

// Hours of a camera that shows light to the power of `exponent`: surfaces return more light in some hours than in
// others, all alike, one in twelve is in the sun, and haze is patchy.
std::vector<KeptReadings> hours_shown(const std::vector<FadingTower>& towers, double exponent, int count,
                                      std::uint64_t seed) {
  fixtures::Random random(seed);
  std::vector<KeptReadings> hours;
  for (int t = 0; t < count; ++t) {
    const double per_m = 1.16e-5 + 6e-5 * std::exp(0.7 * random.normal()), brighter = 0.3 * random.normal();
    KeptReadings hour{{}, 0.04 * t};
    for (const auto& tower : towers) {
      const double kept = std::exp(-per_m * tower.distance_m * (1.0 + 0.05 * random.normal()));
      const double sun = random.uniform() < 1.0 / 12.0 ? 0.4 * random.uniform() : 0.01 * random.normal();
      const double own = tower.contrast - (1.0 - tower.contrast) * brighter - sun;
      const double light = std::max(0.003, 1.0 - own * kept);
      const double contrast = 1.0 - std::pow(light, exponent) + 0.006 * random.normal();
      hour.readings.push_back({true, "", glm::dvec3(contrast), glm::dvec3(0.006)});
    }
    hours.push_back(std::move(hour));
  }
  return hours;
}

TEST(ContrastTone, IsFoundOfCamerasOfKnownCurve) {
  for (const double exponent : {0.7, 1.0, 1.5}) {
    int within = 0;
    double off = 0.0;
    constexpr int kCameras = 3;
    for (int camera = 0; camera < kCameras; ++camera) {
      auto watch = watch_of(kFadingTowers);
      ASSERT_TRUE(watch.resume(hours_shown(kFadingTowers, exponent, 100, 40 + camera)));
      const auto& tone = watch.tone();
      ASSERT_TRUE(tone.known());
      EXPECT_EQ(tone.pictures, 100U);
      within += std::abs(std::log(tone.exponent / exponent)) <= 2.0 * tone.log_sigma;
      off += std::log(tone.exponent / exponent) / kCameras;
      EXPECT_LT(tone.log_sigma, 0.15);
    }
    fmt::print("tone exponent {:.2f}: off by {:+.3f} in the mean, {} of {} within 2 sigma\n", exponent, off, within,
               kCameras);
    EXPECT_LT(std::abs(off), 0.07) << exponent;
    EXPECT_EQ(within, kCameras) << exponent;
  }
}

TEST(ContrastTone, IsNotKnownByFewPicturesOrFewLandmarks) {
  auto few = watch_of(kFadingTowers);
  ASSERT_TRUE(few.resume(hours_shown(kFadingTowers, 1.4, 19, 3)));
  EXPECT_FALSE(few.tone().known());
  EXPECT_EQ(few.tone().exponent, 1.0);
  const std::vector<FadingTower> three(kFadingTowers.begin(), kFadingTowers.begin() + 3);
  auto short_of = watch_of(three);
  ASSERT_TRUE(short_of.resume(hours_shown(three, 1.4, 60, 3)));
  EXPECT_FALSE(short_of.tone().known());
  auto early = watch_of(kFadingTowers), late = early;
  ASSERT_TRUE(early.resume(hours_shown(kFadingTowers, 1.0, 25, 3)));
  ASSERT_TRUE(late.resume(hours_shown(kFadingTowers, 1.0, 100, 3)));
  EXPECT_GT(early.tone().log_sigma, 1.3 * late.tone().log_sigma);
}

TEST(ContrastTone, CostsLittleBesideTheSolutionOfTheLandmarks) {
  std::vector<LawOfLandmark> laws;
  ContrastBelief before;
  std::vector<FadingTower> towers;
  for (int i = 0; i < 16; ++i) towers.push_back(kFadingTowers[static_cast<std::size_t>(i) % kFadingTowers.size()]);
  for (const auto& tower : towers) laws.push_back({tower.distance_m});
  before.mean.assign(towers.size(), 0.94);
  before.floor.assign(towers.size(), 0.0);
  before.floor_sigma.assign(towers.size(), 0.01);
  before.covariance.assign(towers.size() * towers.size(), 0.0018);
  for (std::size_t i = 0; i < towers.size(); ++i) before.covariance[i * (towers.size() + 1)] = 0.0036;
  std::vector<ToneSample> hours;
  for (const auto& hour : hours_shown(towers, 1.2, 200, 5)) {
    hours.push_back({{}, 7e-5});
    for (const auto& one : hour.readings) hours.back().readings.push_back({one.contrast.g, one.sigma.g, true});
  }
  double least_ms = 1e9;
  for (int k = 0; k < 3; ++k) {
    const auto start = std::chrono::steady_clock::now();
    EXPECT_NEAR(contrast_tone(hours, laws, before, 7e-5).exponent, 1.2, 0.15);
    least_ms =
        std::min(least_ms, std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
  }
  fmt::print("tone by 200 pictures of 16 landmarks: {:.0f} ms\n", least_ms);
  EXPECT_LT(least_ms, 400.0) << "of a busy machine; some 40 ms of an idle one";
}

}  // namespace
}  // namespace kasumi
