// Haze over a picture: attenuation, blur and airlight combined.
#include <cmath>

#include <gtest/gtest.h>

#include "calib/colour/spectral_sensitivity.hpp"
#include "estimator/haze/haze_picture.hpp"
#include "tests/estimator/haze/haze_scenes.hpp"

namespace kasumi {
namespace {

constexpr auto kMatched = DiffusionScheme::matched;

HazeRange range_of(const Image<float>& range) {
  HazeRange made;
  made.range = range;
  made.steps_along_row = range_steps_along_row(range);
  made.steps_down_column = range_steps_down_column(range);
  return made;
}

TEST(HazePicture, AUniformWallFadesByBeerAndLambertIntoTheAirlight) {
  const glm::vec3 wall(0.2F, 0.5F, 0.1F);
  const glm::dvec3 airlight(0.7, 0.8, 0.9);
  const auto range = range_of(Image<float>(60, 50, 0.8F));
  const auto hazed =
      under_haze(Image<glm::vec3>(60, 50, wall), range, haze_optics(0.5, 0.75, 15.0), airlight, kMatched);
  ASSERT_TRUE(hazed);
  const double left = std::exp(-(0.5 + 0.75) * 0.8);  // H Eq 1
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(hazed->light.at(30, 25)[c], static_cast<double>(wall[c]) * left + airlight[c] * (1.0 - left), 1e-5);
}

TEST(HazePicture, ChannelsThatFadeUnequallyShareOneBlurredTransmission) {
  // Two halves of one wall, far and near by range but one surface. Reference: each channel separately, compositing the
  // blurred Gamma E and the blurred Gamma.
  constexpr int width = 90, height = 40;
  HazeOptics optics;
  optics.extinction = {glm::dvec3(0.4, 0.9, 1.8), glm::dvec3(0.0)};
  optics.scattering = 0.9;
  optics.lambda = 6.0;
  const glm::dvec3 airlight(0.6, 0.7, 0.9);
  Image<float> ranges(width, height);
  Image<glm::vec3> light(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      ranges.at(x, y) = 0.5F + 0.5F * static_cast<float>(x) / width;
      light.at(x, y) = (x / 7 + y / 5) % 2 == 0 ? glm::vec3(0.9F, 0.3F, 0.1F) : glm::vec3(0.05F, 0.4F, 0.8F);
    }
  const auto range = range_of(ranges);
  const auto map = blur_map(range, optics);
  const auto hazed = under_haze(light, range, optics, airlight, kMatched).value();
  for (int c = 0; c < 3; ++c) {
    Image<glm::vec4> alone(width, height);
    for (std::size_t i = 0; i < alone.elements().size(); ++i) {
      const auto left = std::exp(-optics.extinction[0][c] * static_cast<double>(ranges.elements()[i]));
      alone.elements()[i] =
          glm::vec4(static_cast<float>(left) * light.elements()[i][c], static_cast<float>(left), 0, 0);
    }
    const auto blurred = diffuse(kMatched, alone, map).value();
    for (const int x : {3, 44, 86}) {
      const auto by_hand =
          static_cast<double>(blurred.at(x, 20).r) + (1.0 - static_cast<double>(blurred.at(x, 20).g)) * airlight[c];
      EXPECT_NEAR(hazed.light.at(x, 20)[c], by_hand, 2e-6);
    }
  }
}

TEST(HazePicture, ForATurbidityItFadesAsTheAirDoes) {
  const auto measure = spectral_measure(generic_sensitivity());
  const auto nodes = attenuation_nodes(measure);
  constexpr double kFarthest_m = 12e3, kAltitude_m = 400.0;
  const auto optics = haze_optics(nodes, ScatteringModel::morales2017, Turbidity{4.0}, kAltitude_m, kFarthest_m, 15.0);
  for (const double range : {0.1, 0.5, 1.0}) {
    const auto left = optics.transmission(range);
    const auto truth = attenuation_reference(measure, ScatteringModel::morales2017, Turbidity{4.0},
                                             optical_path(kAltitude_m, kAltitude_m, range * kFarthest_m));
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(left[c], truth[c], 3e-4);
    EXPECT_LT(left.b, left.r) << "the blue is scattered most";
  }
  EXPECT_NEAR(optics.sigma_px(1.0), 1.0 + 15.0 * std::sqrt(optics.scattering), 1e-9);  // H Eq 7
  EXPECT_NEAR(optics.sigma_px(0.0), 1.0, 1e-12);
}

TEST(HazePicture, NearThingsStaySharpAndFarOnesDoNot) {
  constexpr int kSize = 120;
  Image<glm::vec3> light(kSize, kSize);
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) light.at(x, y) = glm::vec3(x % 4 < 2 ? 0.8F : 0.2F);
  const auto contrast = [&](float range_here) {
    Image<float> ranges(kSize, kSize, range_here);
    const auto hazed =
        under_haze(light, range_of(ranges), haze_optics(0.0, 0.25, 15.0), {0.8, 0.8, 0.8}, kMatched).value();
    float least = 2.0F, most = 0.0F;
    for (int x = 50; x < 70; ++x) {
      least = std::min(least, hazed.light.at(x, 60).g);
      most = std::max(most, hazed.light.at(x, 60).g);
    }
    return static_cast<double>(most - least) / (0.6 * std::exp(-0.25 * static_cast<double>(range_here)));
  };
  // Bars of four pixels are one frequency: a Gaussian of variance v leaves exp(-v (pi / 2)^2 / 2) of their contrast.
  const double near = 1.0 + 15.0 * 0.5 * std::pow(0.05, 1.5);
  EXPECT_NEAR(contrast(0.05F), std::exp(-0.5 * (near * near - 1.0) * 0.25 * 9.8696), 0.03);
  EXPECT_LT(contrast(1.0F), 0.01) << "sigma 8.5 px over bars of two pixels";
}

}  // namespace
}  // namespace kasumi
