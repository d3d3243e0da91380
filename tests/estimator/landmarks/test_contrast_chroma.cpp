// A camera's saturation by haze's fading colours; truth is analytic.
#include <cmath>
#include <random>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <glm/glm.hpp>

#include "estimator/air/scattering.hpp"
#include "estimator/landmarks/contrast_chroma.hpp"

namespace kasumi {
namespace {

const glm::dvec3 kWavelengths_nm{638.0, 547.0, 438.0};
constexpr double kPath_m = 2500.0;

// Extinction as a camera of that chroma shows it, hour by hour, in aerosols of that exponent.
std::vector<glm::dvec3> hours_seen(int count, double chroma, double exponent, double scatter = 0.3) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  std::vector<glm::dvec3> all;
  for (int i = 0; i < count; ++i) {
    const double per_m = 3e-5 * std::exp(0.8 * normal(random)), own = exponent + scatter * normal(random);
    glm::dvec3 contrast{0.0};
    for (int c = 0; c < 3; ++c)
      contrast[c] = std::exp(-kPath_m * (rayleigh_per_m(ScatteringModel::aerosol, kWavelengths_nm[c]) +
                                         per_m * std::pow(kWavelengths_nm[c] / 550.0, -own)));
    const double grey = glm::dot(contrast, glm::dvec3{0.21, 0.72, 0.07});
    all.push_back(-glm::log(grey + chroma * (contrast - grey)) / kPath_m);
  }
  return all;
}

ContrastChroma learnt(int count, double chroma, double exponent) {
  return contrast_chroma(hours_seen(count, chroma, exponent), kWavelengths_nm, 0.0, kPath_m);
}

TEST(ContrastChroma, IsFoundByHazesFadingColours) {
  for (const double chroma : {1.0, 1.3, 1.7, 2.2}) {
    const auto found = learnt(60, chroma, 1.3);
    fmt::print("chroma {:.2f}: found {:.2f} +- {:.0f} %, drawn by {:.2f}\n", chroma, found.chroma,
               100.0 * found.log_sigma, saturation_believed(found));
    ASSERT_TRUE(found.known());
    EXPECT_NEAR(std::log(found.chroma), std::log(chroma), 0.1);
    EXPECT_GT(found.pictures, 40U);
  }
}

TEST(ContrastChroma, IsAsSureAsAerosolsAreAlike) {
  for (const double exponent : {0.95, 1.65}) {
    const auto found = learnt(60, 1.6, exponent);
    EXPECT_LE(std::abs(std::log(found.chroma / 1.6)), 2.0 * found.log_sigma) << exponent;
    EXPECT_GE(found.log_sigma, 0.05);
    EXPECT_LE(found.log_sigma, 0.4);
  }
}

TEST(ContrastChroma, IsNotKnownByFewPicturesOrWithoutHaze) {
  EXPECT_FALSE(learnt(11, 1.7, 1.3).known());
  EXPECT_EQ(learnt(11, 1.7, 1.3).chroma, 1.0);
  EXPECT_EQ(saturation_believed(learnt(11, 1.7, 1.3)), 1.0);
  const std::vector<glm::dvec3> clear(60, glm::dvec3{7e-6, 1.2e-5, 3e-5});
  EXPECT_FALSE(contrast_chroma(clear, kWavelengths_nm, 0.0, kPath_m).known());
}

TEST(ContrastChroma, OfACameraThatExaggeratesLittleIsHardlyBelieved) {
  EXPECT_EQ(saturation_believed({1.0, 0.1, 60}), 1.0);
  const double little = saturation_believed({1.1, 0.1, 60}), much = saturation_believed({1.7, 0.1, 60});
  EXPECT_GE(little, 1.0);
  EXPECT_LT(little, 1.06);
  EXPECT_NEAR(much, 1.7, 0.02);
  EXPECT_LT(saturation_believed({1.7, 0.3, 60}), much);  // the less it is known, the less is done
}

}  // namespace
}  // namespace kasumi
