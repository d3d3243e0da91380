// The baselines against scenes whose haze is known in closed form.
#include <cmath>

#include <gtest/gtest.h>

#include "calib/mask/guided_filter.hpp"
#include "tests/paper/single_image.hpp"

namespace kasumi::paper {
namespace {

glm::vec3 guide_at(int x, int y) {
  return {0.5F + 0.4F * std::sin(0.31F * static_cast<float>(x)), 0.5F + 0.4F * std::cos(0.23F * static_cast<float>(y)),
          static_cast<float>((x * 7 + y * 13) % 10) / 10.0F};
}
Image<glm::vec3> guide_of(int width, int height) {
  Image<glm::vec3> guide(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) guide.at(x, y) = guide_at(x, y);
  return guide;
}

TEST(GuidedFilter, KeepsAffineFunctionsOfItsGuide) {
  const auto guide = guide_of(50, 40);
  Image<float> input(50, 40);
  for (std::size_t i = 0; i < input.elements().size(); ++i) {
    const auto& g = guide.elements()[i];
    input.elements()[i] = 0.2F + 0.5F * g.r - 0.3F * g.g + 0.1F * g.b;
  }
  const auto kept = guided_filter(guide, input, 6, 1e-9);
  for (std::size_t i = 0; i < input.elements().size(); ++i)
    ASSERT_NEAR(kept.elements()[i], input.elements()[i], 1e-5F) << i;
}

// With a flat guide the windows' means are averaged: a single spike becomes a pyramid, 9 x 9 wide for a radius of 2,
// whose peak averages 25 windows of 25 pixels each.
TEST(GuidedFilter, AveragesTwiceWhereTheGuideIsFlat) {
  Image<float> input(31, 31);
  input.at(15, 15) = 1.0F;
  const auto smooth = guided_filter(Image<glm::vec3>(31, 31, glm::vec3(0.4F)), input, 2, 1e-3);
  for (int y = 8; y < 24; ++y)
    for (int x = 8; x < 24; ++x) {
      const int across = std::max(0, 5 - std::abs(x - 15)), down = std::max(0, 5 - std::abs(y - 15));
      ASSERT_NEAR(smooth.at(x, y), static_cast<float>(across * down) / 625.0F, 1e-6F) << x << ", " << y;
    }
}

// One pixel in every patch is black in some channel: then the darkest light nearby is that of the haze, and
// transmission is exact up to the haze that omega keeps.
TEST(DarkChannel, GivesTheTransmissionOfASceneWithBlackInEveryPatch) {
  const glm::vec3 airlight{0.8F, 0.85F, 0.9F};
  for (const float t : {0.9F, 0.6F, 0.3F}) {
    Image<glm::vec3> hazy(90, 60), relative(90, 60);
    for (int y = 0; y < 60; ++y)
      for (int x = 0; x < 90; ++x) {
        auto colour = guide_at(x, y);
        if (x % 5 == 0 && y % 5 == 0) colour[(x / 5 + y / 5) % 3] = 0.0F;
        hazy.at(x, y) = airlight * (colour * t + 1.0F - t);
        relative.at(x, y) = hazy.at(x, y) / airlight;
      }
    const auto found = transmission_by_dark_channel(relative, hazy);
    for (const float value : found.elements()) ASSERT_NEAR(value, 1.0F - 0.95F * (1.0F - t), 2e-3F);
  }
}

TEST(DarkChannel, FindsTheLightFromInfinityInTheThickestHaze) {
  const glm::vec3 airlight{0.7F, 0.75F, 0.8F};
  Image<glm::vec3> hazy(200, 100);
  for (int y = 0; y < 100; ++y)
    for (int x = 0; x < 200; ++x) {
      const float t = static_cast<float>(y) / 99.0F;
      hazy.at(x, y) = airlight * (0.5F * guide_at(x, y) * t + 1.0F - t);
    }
  hazy.at(100, 95) = glm::vec3(1.0F);  // something white nearby is not haze
  const auto found = airlight_by_dark_channel(hazy);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], static_cast<double>(airlight[c]), 1e-6);
}

TEST(ColourAttenuation, IsThePublishedLinearFunctionOfValueAndSaturation) {
  EXPECT_NEAR(depth_by_colour({0.5F, 0.5F, 0.5F}), 0.121779 + 0.5 * 0.959710, 1e-6);
  EXPECT_NEAR(depth_by_colour({0.2F, 0.8F, 0.4F}), 0.121779 + 0.8 * 0.959710 - 0.75 * 0.780245, 1e-6);
  EXPECT_NEAR(depth_by_colour({0.0F, 0.0F, 0.0F}), 0.121779, 1e-6);
}

TEST(ColourAttenuation, GivesAFlatSceneTheTransmissionOfItsColour) {
  const Image<glm::vec3> flat(64, 48, glm::vec3(0.6F, 0.7F, 0.65F));
  const double depth = 0.121779 + 0.7 * 0.959710 - (0.1 / 0.7) * 0.780245;
  const auto found = transmission_by_colour(flat);
  for (const float t : found.elements()) ASSERT_NEAR(t, std::exp(-depth), 1e-5);
}

TEST(WithHazeOf, ThinsAndThickensTheHazeAsTheModelSays) {
  const float t = 0.5F, surface = 0.2F;
  const Image<glm::vec3> hazy(4, 4, glm::vec3(surface * t + 1.0F - t));
  const Image<float> transmission(4, 4, t);
  EXPECT_NEAR(with_haze_of(hazy, transmission, 0.0).at(1, 1).g, surface, 1e-6F);
  EXPECT_NEAR(with_haze_of(hazy, transmission, 1.0).at(1, 1).g, hazy.at(1, 1).g, 1e-6F);
  EXPECT_NEAR(with_haze_of(hazy, transmission, 3.0).at(1, 1).g, surface * 0.125F + 0.875F, 1e-6F);
}

}  // namespace
}  // namespace kasumi::paper
