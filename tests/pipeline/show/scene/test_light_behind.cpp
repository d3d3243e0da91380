// The air's light before the object, as the pixels behind it bound it.
#include <gtest/gtest.h>
#include <glm/glm.hpp>

#include "gles/light/airlight_grid.hpp"
#include "pipeline/show/scene/light_behind.hpp"
#include "pipeline/show/scene/scene_air.hpp"

namespace kasumi {
namespace {

constexpr int kAcross = 96, kDown = 64, kHorizon = 20;  // below that row: land
constexpr PixelBox kOnTheHill{36, 30, 68, 54};

// Looks north, level; a grey sky of 0.6 above a hill of which the camera sees `hill`.
struct BeforeAHill : testing::Test {
  BeforeAHill() {
    installation.scene.width = kAcross;
    installation.scene.height = kDown;
    installation.scene.lens = pinhole_lens({{400.0, 400.0}, {47.5, 19.5}, {}});
    installation.scene.to_world = glm::dmat3({1, 0, 0}, {0, 0, -1}, {0, 1, 0});
    installation.object.placement.north_m = 3500.0;
    report.sun = {SunSource::ephemeris, SunDirection{0.0, -0.6, 0.8}, std::nullopt, false, {}};
  }
  Image<Rgb8> picture(const glm::dvec3& hill) const {
    const auto code = [&](const glm::dvec3& light) {
      return Rgb8(glm::round(255.0 * installation.scene.response.to_encoded(light)));
    };
    Image<Rgb8> made(kAcross, kDown, code(hill));
    for (int y = 0; y < kHorizon; ++y)
      for (int x = 0; x < kAcross; ++x) made.at(x, y) = code(sky);
    return made;
  }
  HorizonLight horizon() const {
    HorizonLight seen;
    seen.source = HorizonLight::Source::scene_camera;
    seen.columns = {{Radians{0.0}, from_degrees(89.5), sky, 1.0}};
    return seen;
  }
  // Light before the object in that air, with what is seen behind it or without.
  AirlightGrid drawn(double turbidity, const Image<Rgb8>& seen, bool looked = true) const {
    AirRendering options;
    options.turbidity = Turbidity{turbidity};
    SceneAir air(installation, options);
    HorizonAnswer answer{air.observer(), {}, horizon()};
    if (looked) answer.behind = light_behind(installation.scene, view_of(seen), kOnTheHill, answer.seen);
    air.adopt(answer);
    return air.measured(air.conditions(report), kOnTheHill);
  }
  Installation installation;
  SkyReport report;
  glm::dvec3 sky{0.6};
};

TEST_F(BeforeAHill, FogIsAsBrightAsTheCameraSeesItThere) {
  const glm::dvec3 in_fog{0.30, 0.31, 0.33};
  const auto seen = picture(in_fog);
  const auto grid = drawn(40.0, seen), before = drawn(40.0, seen, false);
  for (std::size_t i = 0; i < grid.light.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(grid.light[i][c] / in_fog[c], 1.0, 0.06) << i << ", channel " << c;
      EXPECT_GT(before.light[i][c], 1.5 * in_fog[c]) << "it would stand before the hill as a bright board";
    }
}

// A black hill shows as much light as the air puts before it, also where that is thinner by a third than believed.
TEST_F(BeforeAHill, ABlackHillInTheAirThatIsBelievedBindsNothing) {
  for (const double turbidity : {1.8, 2.5, 4.0, 6.0, 12.0, 25.0}) {
    AirRendering options;
    options.turbidity = Turbidity{turbidity};
    const SceneAir air(installation, options);
    const auto appearance = air.appearance(air.conditions(report), kOnTheHill);
    glm::dvec3 left{0.0};
    for (std::size_t k = 0; k < kHazeNodes; ++k)
      left += appearance.haze.weight[k] *
              glm::exp(-3500.0 * (appearance.haze.rayleigh_per_m[k] + appearance.haze.mie_per_m[k]));
    const auto seen = picture((1.0 - glm::pow(left, glm::dvec3{0.67})) * sky);
    const auto grid = drawn(turbidity, seen), before = drawn(turbidity, seen, false);
    for (std::size_t i = 0; i < grid.light.size(); ++i)
      EXPECT_NEAR(grid.light[i].g / before.light[i].g, 1.0, 0.03) << turbidity;
  }
}

TEST_F(BeforeAHill, WhatStandsBeforeTheObjectSaysNothing) {
  auto seen = picture({0.35, 0.35, 0.35});
  installation.scene.mask = Image<std::uint8_t>(kAcross, kDown, 255);
  for (int y = 0; y < kDown; ++y)
    for (int x = 0; x < kAcross / 2; ++x) {
      installation.scene.mask.at(x, y) = 0;  // a tree, nearly black
      seen.at(x, y) = Rgb8(5, 5, 5);
    }
  const auto grid = drawn(40.0, seen), before = drawn(40.0, seen, false);
  const glm::dvec2 left_side{36.0, 42.0}, right_side{67.0, 42.0};
  EXPECT_EQ(airlight_at(grid, left_side).g, airlight_at(before, left_side).g);
  EXPECT_NEAR(airlight_at(grid, right_side).g, 0.35, 0.03);
}

TEST_F(BeforeAHill, APictureOfAnotherSizeSaysNothing) {
  const Image<Rgb8> other(10, 10);
  EXPECT_FALSE(light_behind(installation.scene, view_of(other), kOnTheHill, horizon()));
  EXPECT_FALSE(light_behind(installation.scene, view_of(picture(sky)), {}, horizon()));
  EXPECT_FALSE(light_behind(installation.scene, view_of(picture(sky)), kOnTheHill, {}));
}

}  // namespace
}  // namespace kasumi
