#include <cmath>

#include <gtest/gtest.h>

#include "calib/light/radiometry.hpp"

namespace kasumi {
namespace {

std::vector<Response> responses() {
  std::vector<double> gamma;
  for (int i = 0; i <= 255; ++i) gamma.push_back(std::pow(i / 255.0, 2.2));
  return {Response::linear(), Response::srgb(),
          Response::table({gamma, std::vector{0.0, 0.1, 0.5, 1.0}, std::vector{0.0, 1.0}})};
}

TEST(Response, SrgbHasTheValuesOfIec61966) {
  const auto srgb = Response::srgb();
  EXPECT_NEAR(srgb.to_light({0.5, 0.0, 1.0}).r, 0.214041140482, 1e-12);
  EXPECT_NEAR(srgb.to_encoded({0.18, 0.0, 1.0}).r, 0.461356129500, 1e-12);
  EXPECT_NEAR(srgb.to_light({0.02, 0.0, 1.0}).r, 0.02 / 12.92, 1e-15);
  EXPECT_EQ(srgb.to_light({0.5, 0.0, 1.0}).g, 0.0);
  EXPECT_NEAR(srgb.to_light({0.5, 0.0, 1.0}).b, 1.0, 1e-15);
}

TEST(Response, DecodingUndoesEncodingInAndAroundTheRange) {
  for (const auto& response : responses())
    for (double encoded = -0.1; encoded <= 1.2; encoded += 1e-4) {
      const auto back = response.to_encoded(response.to_light(glm::dvec3{encoded}));
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(back[c], encoded, 1e-9);
    }
}

// sRGB itself has a discontinuity of 2e-9 where its branches meet (.04045 / 12.92 against ((.04045 + .055) /
// 1.055)^2.4).
TEST(Response, EncodingUndoesDecodingInAndAroundTheRange) {
  for (const auto& response : responses())
    for (double light = -0.05; light <= 1.2; light += 1e-5) {
      const auto back = response.to_light(response.to_encoded(glm::dvec3{light}));
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(back[c], light, 3e-9);
    }
}

TEST(Response, TheSlopeIsTheDifferenceQuotient) {
  const double h = 1e-6;
  for (const auto& response : responses())
    for (double encoded = 0.013; encoded < 1.0; encoded += 0.0371) {
      const auto rise =
          (response.to_light(glm::dvec3{encoded + h}) - response.to_light(glm::dvec3{encoded - h})) / (2 * h);
      const auto slope = response.slope(glm::dvec3{encoded});
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(slope[c], rise[c], 1e-5 * (1.0 + rise[c])) << encoded;
    }
}

TEST(Response, ATableIsLinearBetweenItsEvenlySpacedValues) {
  const auto table = Response::table({std::vector{0.0, 0.1, 1.0}, {0.0, 0.5, 1.0}, {0.0, 0.9, 1.0}});
  const auto light = table.to_light(glm::dvec3{0.25});
  EXPECT_NEAR(light.r, 0.05, 1e-15);
  EXPECT_NEAR(light.g, 0.25, 1e-15);
  EXPECT_NEAR(light.b, 0.45, 1e-15);
  EXPECT_NEAR(table.to_light(glm::dvec3{1.0}).r, 1.0, 1e-15);
}

TEST(Vignetting, IsTheEvenPolynomialOfTheDistanceFromItsCentre) {
  const Vignetting vignetting{{10.0, 20.0}, 100.0, {-0.3, 0.1, -0.05}};
  EXPECT_EQ(vignetting.at({10.0, 20.0}), 1.0);
  EXPECT_NEAR(vignetting.at({10.0 + 30.0, 20.0 - 40.0}), 1.0 - 0.3 * 0.25 + 0.1 * 0.0625 - 0.05 * 0.015625, 1e-15);
  EXPECT_GT(vignetting.at({1000.0, 1000.0}), 0.0);
  EXPECT_EQ(Vignetting{}.at({123.0, 456.0}), 1.0);
}

}  // namespace
}  // namespace kasumi
