// Extinction from contrasts, against Koschmieder's law itself.
#include <cmath>

#include <gtest/gtest.h>

#include "estimator/landmarks/channel_extinctions.hpp"
#include "fixtures/noise/random.hpp"

namespace kasumi {
namespace {

constexpr double kClearest_per_m = 1e-5;

std::vector<ContrastLandmark> at(const std::vector<double>& distances_m, double contrast_sigma = 0.1) {
  std::vector<ContrastLandmark> landmarks;
  for (const double distance_m : distances_m) {
    ContrastLandmark landmark;
    landmark.distance_m = distance_m;
    landmark.contrast = 0.85;
    landmark.contrast_sigma = contrast_sigma;
    landmark.infinity_sigma = 1e-3;
    landmarks.push_back(landmark);
  }
  return landmarks;
}

ContrastReading reading(double contrast, double sigma) {
  return {true, "", glm::dvec3{contrast}, glm::dvec3{sigma}};
}

constexpr ContrastSpread kNoSpread{0.0, 0.0, 0.0, 0.0, 0.0, 0.0};

TEST(LandmarkExtinction, IsKoschmiedersWhereContrastsAreKnown) {
  const auto landmarks = at({500.0, 2000.0, 8000.0}, 0.005);
  const LandmarkExtinction law(landmarks, 0.0, kClearest_per_m, 1, kNoSpread);
  for (const double truth : {5e-5, 2e-4, 1e-3}) {
    std::vector<ContrastReading> readings;
    for (const auto& landmark : landmarks)
      readings.push_back(reading(0.85 * std::exp(-truth * landmark.distance_m), 1e-3));
    const auto found = law.estimate(readings);
    ASSERT_EQ(found.kind, ExtinctionKind::value) << found.reason;
    EXPECT_NEAR(found.per_m / truth, 1.0, 2e-3);
    EXPECT_LT(found.lowest_per_m, truth);
    EXPECT_GT(found.highest_per_m, truth);
  }
}

// One surface against its neighbour: the difference fades like the contrast to the sky.
TEST(LandmarkExtinction, OfTwoSurfacesSideBySideIsTheSame) {
  auto landmarks = at({400.0}, 0.005);
  landmarks[0].contrast = 0.3;
  landmarks[0].against = LandmarkBox{0, 0, 1, 1};
  const LandmarkExtinction law(landmarks, 0.0, kClearest_per_m, 1, kNoSpread);
  const auto found = law.estimate({reading(0.3 * std::exp(-2e-3 * 400.0), 1e-3)});
  ASSERT_EQ(found.kind, ExtinctionKind::value) << found.reason;
  EXPECT_NEAR(found.per_m, 2e-3, 1e-5);
}

// Readings drawn from the stated model: sigma must match the errors.
TEST(LandmarkExtinction, SigmaIsThatOfTheErrors) {
  const auto landmarks = at({800.0, 1500.0, 3000.0, 6000.0});
  ContrastSpread spread;
  spread.airlight = spread.fog_patchy = 0.0;
  const LandmarkExtinction law(landmarks, 0.0, kClearest_per_m, 1, spread);
  fixtures::Random random(41);
  const double truth = 4e-4;
  double squares = 0.0;
  int draws = 0, within_two = 0;
  for (int i = 0; i < 400; ++i) {
    const double together = random.normal(), lit_together = random.normal();
    std::vector<ContrastReading> readings;
    for (const auto& landmark : landmarks) {
      const double share = spread.known_together;
      const double contrast = 0.85 + 0.1 * (std::sqrt(share) * together + std::sqrt(1.0 - share) * random.normal());
      const double lit = 0.15 * (spread.lit_together * lit_together + spread.lit_each * random.normal());
      const double depth = truth * landmark.distance_m * (1.0 + spread.patchy * random.normal());
      readings.push_back(reading((contrast + lit) * std::exp(-depth) + 0.01 * random.normal(), 0.01));
    }
    const auto found = law.estimate(readings);
    if (found.kind != ExtinctionKind::value) continue;
    ++draws;
    const double off = (found.per_m - truth) / found.sigma_per_m;
    squares += off * off;
    if (found.lowest_per_m <= truth && truth <= found.highest_per_m) ++within_two;
  }
  ASSERT_GT(draws, 380);
  EXPECT_NEAR(std::sqrt(squares / draws), 1.0, 0.15) << "root mean square of errors over sigma";
  EXPECT_GT(within_two, 0.92 * draws) << "95.4 % expected";
}

TEST(LandmarkExtinction, GivesABoundWhereLandmarksEnd) {
  ContrastSpread even;
  even.fog_patchy = 0.0;
  const LandmarkExtinction law(at({100.0, 200.0, 300.0}), 0.0, kClearest_per_m, 1, even);
  const auto clear = law.estimate({reading(0.85, 0.01), reading(0.85, 0.01), reading(0.84, 0.01)});
  EXPECT_EQ(clear.kind, ExtinctionKind::at_most);
  EXPECT_FALSE(clear.reason.empty());
  EXPECT_LT(clear.highest_per_m, 3e-3) << "three hundred metres tell 1.3 km from more";
  EXPECT_GT(clear.highest_per_m, 1e-4) << "but not 40 km from more";
  const auto fog = law.estimate({reading(0.0, 0.02), reading(0.01, 0.02), reading(-0.01, 0.02)});
  EXPECT_EQ(fog.kind, ExtinctionKind::at_least);
  EXPECT_GT(fog.lowest_per_m, std::log(0.85 / 0.1) / 100.0) << "the nearest is gone but for a tenth";
  EXPECT_EQ(law.estimate({}).kind, ExtinctionKind::nothing);
}

// What these landmarks say of fog, against fog elsewhere that has as many times more as less.
TEST(LandmarkExtinction, SigmaHoldsFogElsewhere) {
  const auto landmarks = at({100.0, 200.0, 300.0}, 0.01);
  ContrastSpread spread = kNoSpread;
  spread.fog_patchy = 0.8;
  const LandmarkExtinction law(landmarks, 0.0, kClearest_per_m, 1, spread);
  const auto found_in = [&](double per_m) {
    std::vector<ContrastReading> readings;
    for (const auto& landmark : landmarks)
      readings.push_back(reading(0.85 * std::exp(-per_m * landmark.distance_m), 2e-3));
    return law.estimate(readings);
  };
  const double fog = 8e-3, haze = 8e-5;
  const auto found = found_in(fog);
  ASSERT_EQ(found.kind, ExtinctionKind::value) << found.reason;
  fixtures::Random random(7);
  int within_one = 0, within_two = 0;
  constexpr int kDraws = 2000;
  for (int i = 0; i < kDraws; ++i) {
    const double elsewhere = fog * std::exp(spread.fog_patchy * random.normal());
    within_one += std::abs(found.per_m - elsewhere) <= found.sigma_per_m;
    within_two += found.lowest_per_m <= elsewhere && elsewhere <= found.highest_per_m;
  }
  EXPECT_NEAR(static_cast<double>(within_one) / kDraws, 0.70, 0.08);
  EXPECT_NEAR(static_cast<double>(within_two) / kDraws, 0.95, 0.02);
  EXPECT_LT(found_in(haze).sigma_per_m, 0.5 * haze) << "haze is much the same elsewhere";
}

TEST(LandmarkExtinction, LeavesOutWhatTheOthersDoNotPredict) {
  const std::vector<double> distances_m{500.0, 1000.0, 1500.0, 2000.0, 2500.0};
  const LandmarkExtinction law(at(distances_m), 0.0, kClearest_per_m, 1);
  std::vector<ContrastReading> readings;
  for (const double distance_m : distances_m) readings.push_back(reading(0.85 * std::exp(-8e-4 * distance_m), 0.01));
  const auto all = law.estimate(readings);
  readings[3] = reading(-0.4, 0.01);  // snow in the sun
  const auto found = law.estimate(readings);
  ASSERT_EQ(found.left_out, std::vector<std::size_t>{3});
  EXPECT_NEAR(found.per_m / all.per_m, 1.0, 0.1);
  EXPECT_EQ(found.landmarks, 4);
}

TEST(LandmarkContrast, IsReadInLinearLight) {
  Camera camera;
  camera.width = 64;
  camera.height = 48;
  camera.vignetting = {{31.5, 23.5}, 40.0, {-0.3, 0.0, 0.0}};
  camera.white_balance = {0.8, 1.0, 0.9};
  const glm::dvec3 sky{0.5, 0.55, 0.6}, surface{0.1, 0.15, 0.3};
  Image<glm::vec3> encoded(64, 48);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x) {
      const auto light = (y < 24 ? sky : surface) * camera.white_balance * camera.vignetting.at({x, y});
      encoded.at(x, y) = glm::vec3(camera.response.to_encoded(light));
    }
  ContrastLandmark landmark;
  landmark.surface = {5, 28, 12, 12};
  landmark.sky = LandmarkBox{40, 6, 16, 12};
  auto readings = read_contrasts(camera, encoded, {landmark});
  ASSERT_TRUE(readings[0].usable) << readings[0].reason;
  const auto expected = 1.0 - surface / sky;
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(readings[0].contrast[c], expected[c], 1e-5);
    EXPECT_NEAR(readings[0].sigma[c], 0.005, 0.003) << "flare and the pixels' noise";
  }
  for (int y = 6; y < 18; ++y)
    for (int x = 40; x < 56; ++x) encoded.at(x, y) = glm::vec3(1.0F);
  readings = read_contrasts(camera, encoded, {landmark});
  EXPECT_TRUE(readings[0].usable);
  EXPECT_EQ(readings[0].reason, "the sky next to it is clipped");
  EXPECT_GT(readings[0].sigma.g, 0.02);
  landmark.surface.x = 60;
  EXPECT_FALSE(read_contrasts(camera, encoded, {landmark})[0].usable);
}

// Haze thins by e within 1200 m: a path that climbs so far holds (1 - 1/e) of a level one's.
TEST(LandmarkContrast, PathsThatClimbHoldLessHaze) {
  ContrastLandmark landmark;
  landmark.distance_m = 5000.0;
  for (const double altitude_m : {0.0, 900.0}) {
    landmark.rise_m = 0.0;
    EXPECT_NEAR(haze_path_m(landmark, altitude_m), 5000.0, 0.1);
    landmark.rise_m = 1200.0;
    EXPECT_NEAR(haze_path_m(landmark, altitude_m), 5000.0 * (1.0 - std::exp(-1.0)), 0.1);
  }
}

class LandmarkAirTest : public testing::Test {
 protected:
  LandmarkAirTest() : watch(camera, 0.0, at({1000.0, 3000.0, 5000.0}, 0.02)) {}
  ChannelExtinctions air_of(double turbidity) const {
    std::vector<ContrastReading> readings;
    for (const auto& landmark : watch.landmarks()) {
      // Reference at 1 nm.
      const auto left = attenuation_reference(spectral_measure(camera), ScatteringModel::morales2017,
                                              Turbidity{turbidity}, optical_path(0.0, 0.0, landmark.distance_m));
      readings.push_back({true, "", 0.85 * left, glm::dvec3{0.003}});
    }
    return watch.estimate(readings);
  }
  Camera camera;
  LandmarkWatch watch;
};

TEST_F(LandmarkAirTest, IsTheTurbidityThatTakesAsMuch) {
  for (const double truth : {2.0, 3.0, 6.0}) {
    const auto air = air_of(truth);
    ASSERT_TRUE(air.turbidity.turbidity) << air.turbidity.reason;
    EXPECT_NEAR(air.turbidity.turbidity->value / truth, 1.0, 0.03);
    EXPECT_GT(air.turbidity.sigma, 0.0);
    // Koschmieder at 550 nm, near which the green channel is.
    EXPECT_NEAR(air.visibility_m() / meteorological_range_m(Turbidity{truth}, 0.0), 1.0, 0.06);
    EXPECT_NEAR(air.optical_range_m() / air.visibility_m(), std::log(20.0) / std::log(50.0), 1e-3);
  }
}

TEST_F(LandmarkAirTest, ReportsADisagreementAndNeverAverages) {
  const auto air = air_of(4.0);
  const auto same = watch.compare(air, Turbidity{4.0}, 0.05);
  EXPECT_EQ(same.agreement, Agreement::agrees) << same.message;
  EXPECT_LT(std::abs(same.sigmas), 1.0);
  const auto other = watch.compare(air, Turbidity{2.0}, 0.05);
  EXPECT_EQ(other.agreement, Agreement::disagrees) << other.message;
  EXPECT_GT(other.sigmas, 3.0) << "the landmarks see the thicker air";
  EXPECT_NEAR(air.turbidity.turbidity->value, 4.0, 0.15) << "whatever the sky says";
  EXPECT_EQ(watch.compare(air, Turbidity{2.0}, 30.0).agreement, Agreement::agrees) << "who knows little agrees";
}

TEST_F(LandmarkAirTest, TreatsABoundAsABound) {
  const LandmarkWatch near(camera, 0.0, at({100.0, 300.0, 500.0}, 0.05));
  const auto air = near.estimate({reading(0.85, 0.02), reading(0.84, 0.02), reading(0.85, 0.02)});
  ASSERT_EQ(air.extinction().kind, ExtinctionKind::at_most);
  EXPECT_FALSE(air.turbidity.turbidity);
  EXPECT_EQ(near.compare(air, Turbidity{1.7}, 0.01).agreement, Agreement::agrees);
  EXPECT_EQ(near.compare(air, Turbidity{19.0}, 0.3).agreement, Agreement::disagrees);
}

}  // namespace
}  // namespace kasumi
