// Distances estimated from haze, against scenes that meet the method's assumption.
#include <cmath>

#include <gtest/gtest.h>

#include "estimator/photograph/depth_from_haze.hpp"

namespace kasumi {
namespace {

constexpr auto kModel = ScatteringModel::morales2017;
constexpr Turbidity kTurbidity{8.0};

// Something black in some channel in every neighbourhood, behind haze of transmission `left`.
Image<glm::vec3> hazy(int width, int height, auto left) {
  Image<glm::vec3> relative(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      glm::vec3 surface{0.3F, 0.4F, 0.2F};
      surface[(x + y) % 3] = 0.0F;
      const float t = static_cast<float>(left(x, y));
      relative.at(x, y) = surface * t + 1.0F - t;
    }
  return relative;
}
double grey_per_m() {
  return rayleigh_per_m(kModel, 550.0) + mie_per_m(kModel, 550.0, kTurbidity);
}

TEST(DepthFromHaze, IsTheDistanceInASceneWithBlackInEveryNeighbourhood) {
  const DepthParameters all{.kept_haze = 1.0};
  for (const double distance_m : {300.0, 1000.0, 3000.0}) {
    const double left = std::exp(-grey_per_m() * distance_m);
    const auto relative = hazy(120, 80, [&](int, int) { return left; });
    const auto found = depth_from_haze(relative, relative, grey_attenuation_nodes(), kModel, kTurbidity, all);
    for (const float metres : found.elements()) ASSERT_NEAR(metres, distance_m, 0.01 * distance_m);
  }
}

// Haze whose extinction differs by channel: the result is the green channel's optical depth.
TEST(DepthFromHaze, FollowsTheGreenChannelOfColouredHaze) {
  const auto nodes = attenuation_nodes(spectral_measure(generic_sensitivity()));
  const auto haze = haze_coefficients(nodes, kModel, kTurbidity);
  const double left = attenuation(haze, {2000.0, 2000.0}).g;
  const auto relative = hazy(60, 60, [&](int, int) { return left; });
  const auto found = depth_from_haze(relative, relative, nodes, kModel, kTurbidity, {.kept_haze = 1.0});
  EXPECT_NEAR(found.at(30, 30), 2000.0F, 20.0F);
}

// The guided filter leaves no halo: the far side of an edge is far within two pixels.
TEST(DepthFromHaze, ChangesAtTheEdgeOfThePicture) {
  const auto relative = hazy(200, 100, [](int x, int) { return x < 100 ? 0.9 : 0.2; });
  const auto found =
      depth_from_haze(relative, relative, grey_attenuation_nodes(), kModel, kTurbidity, {.kept_haze = 1.0});
  const double near_m = -std::log(0.9) / grey_per_m(), far_m = -std::log(0.2) / grey_per_m();
  EXPECT_NEAR(found.at(60, 50), near_m, 0.1 * near_m);
  EXPECT_NEAR(found.at(140, 50), far_m, 0.1 * far_m);
  EXPECT_LT(found.at(97, 50), 0.5 * far_m);
  EXPECT_GT(found.at(103, 50), 0.5 * far_m);
}

TEST(LightOfHaze, IsThatOfTheThickestHazeWithoutSkyOrHighlights) {
  const glm::vec3 airlight{0.7F, 0.75F, 0.8F};
  Image<glm::vec3> light = hazy(200, 100, [](int, int y) { return y / 99.0; });
  for (auto& value : light.elements()) value *= airlight;
  for (int x = 90; x < 95; ++x) light.at(x, 95) = glm::vec3(1.0F);
  const auto found = light_of_haze(light, light, {});
  for (const auto& value : found.elements())
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(value[c], airlight[c], 0.02F);
}

// Brighter to the right: where sky was found it is its own light of haze, so that nothing is removed from it.
TEST(LightOfHaze, FollowsANonUniformSky) {
  Image<glm::vec3> light(240, 120, glm::vec3(0.1F));
  Image<std::uint8_t> sky(240, 120);
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 240; ++x) {
      light.at(x, y) = glm::vec3(0.6F + 0.1F * static_cast<float>(x) / 239.0F);
      sky.at(x, y) = 255;
    }
  const auto found = light_of_haze(light, light, sky);
  for (int x = 20; x < 220; ++x) ASSERT_NEAR(found.at(x, 20).g / light.at(x, 20).g, 1.0F, 0.02F) << x;
}

TEST(GreyHaze, AttenuatesAllChannelsEqually) {
  const auto left = attenuation(haze_coefficients(grey_attenuation_nodes(), kModel, kTurbidity), {1000.0, 1000.0});
  EXPECT_NEAR(left.g, std::exp(-1000.0 * grey_per_m()), 1e-9);
  EXPECT_NEAR(left.r, left.g, 1e-12);
  EXPECT_NEAR(left.b, left.g, 1e-12);
}

}  // namespace
}  // namespace kasumi
