// Whether the building is visible, and the message about it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/site/config/sighting.hpp"

namespace kasumi {
namespace {

using Verdict = Sighting::Verdict;

// A camera that looks north, focal length 1000 px, 600 x 400 px; a building 40 m wide, 20 m high, 3.5 km north.
class SightingOf : public testing::Test {
 protected:
  SightingOf() {
    Camera& scene = installation.scene;
    scene.width = 600;
    scene.height = 400;
    scene.lens = pinhole_lens({{1000.0, 1000.0}, {299.5, 199.5}, {}});
    look_to(0.0);
    installation.site.altitude_m = 100.0;
    stand_at(0.0, 3500.0, 0.0);
  }
  void look_to(double heading_deg) {
    installation.scene.to_world = camera_to_world(from_degrees(heading_deg), Radians{0.0}, Radians{0.0});
  }
  void stand_at(double east, double north, double up) {
    installation.object.placement.east_m = east;
    installation.object.placement.north_m = north;
    installation.object.placement.up_m = up;
  }
  Sighting now() const { return sight_object(installation, {{-20.0F, 0.0F, -20.0F}, {20.0F, 20.0F, 20.0F}}); }

  Installation installation;
};

TEST_F(SightingOf, ReportsPositionAndSizeInThePicture) {
  const auto sighting = now();
  EXPECT_EQ(sighting.verdict, Verdict::visible);
  EXPECT_NEAR(sighting.distance_m, 3500.0, 1.0);
  // 40 m at 3480 m, the nearer side: 11.5 px; 20 m: 5.7 px
  EXPECT_THAT(sighting.message, testing::HasSubstr("3.50 km away at azimuth 0.0 deg, 11 x 6 pixels"));
}

TEST_F(SightingOf, WhatIsOutOfProportionIsProbablyInAnotherUnit) {
  stand_at(0.0, 3500e3, 0.0);
  EXPECT_THAT(now().message, testing::HasSubstr("a thousand times 3.5"));
  stand_at(0.0, 3.5, 0.0);
  EXPECT_THAT(now().message, testing::HasSubstr("kilometres given for metres?"));
  stand_at(0.0, 3500.0, 0.0);
  EXPECT_THAT(sight_object(installation, {{-.02F, 0.0F, -.02F}, {.02F, .02F, .02F}}).message,
              testing::HasSubstr("is the model in metres?"));
  EXPECT_THAT(now().message, testing::Not(testing::HasSubstr("?")));
}

TEST_F(SightingOf, ATurnedCameraLosesItAndReportsWhere) {
  look_to(30.0);
  EXPECT_EQ(now().verdict, Verdict::outside);
  EXPECT_THAT(now().message, testing::HasSubstr("30.0 deg left"));
  look_to(180.0);
  EXPECT_EQ(now().verdict, Verdict::behind);
  EXPECT_THAT(now().message, testing::HasSubstr("the camera looks to 180.0 deg"));
}

TEST_F(SightingOf, TheEdgeOfThePictureCutsIt) {
  stand_at(3500.0 * 0.2995, 3500.0, 0.0);
  EXPECT_EQ(now().verdict, Verdict::cut_off);
}

TEST_F(SightingOf, TheSeaHidesWhatLiesBeyondItsHorizon) {
  // From 10 m the horizon lies 12.1 km away with refraction .13; 48 km further 158 m are hidden.
  installation.site.altitude_m = 10.0;
  const double distance = 60e3, sea_level = -10.0 - distance * distance / (2.0 * 6371e3);
  stand_at(0.0, distance, sea_level + 100.0);
  EXPECT_EQ(now().verdict, Verdict::below_horizon);
  stand_at(0.0, distance, sea_level + 180.0);
  EXPECT_NE(now().verdict, Verdict::below_horizon);
}

TEST_F(SightingOf, ThingsInFrontHideItOnlyWhenTheyHideAll) {
  auto& mask = installation.scene.mask = Image<std::uint8_t>(600, 400, 255);
  for (int y = 190; y < 210; ++y)
    for (int x = 280; x < 320; ++x) mask.at(x, y) = 0;
  EXPECT_EQ(now().verdict, Verdict::behind_the_mask);
  mask.at(300, 196) = 255;
  EXPECT_EQ(now().verdict, Verdict::visible);
}

TEST_F(SightingOf, AHillInFrontHidesItAndOneBehindDoesNot) {
  auto& distances = installation.scene_distances_m = Image<float>(600, 400, 3000.0F);
  EXPECT_EQ(now().verdict, Verdict::behind_the_mask);
  EXPECT_THAT(now().message, testing::HasSubstr("scene.depth_map"));
  for (const float open_m : {0.0F, 3600.0F}) {
    distances.at(300, 196) = open_m;
    EXPECT_EQ(now().verdict, Verdict::visible) << open_m;
  }
}

}  // namespace
}  // namespace kasumi
