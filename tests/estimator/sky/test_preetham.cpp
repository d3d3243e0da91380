#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "estimator/sky/preetham.hpp"
#include "tests/estimator/turbidity/synthetic_sky.hpp"

namespace kasumi {
namespace {

const Radians kSunZenith = from_degrees(58.4);

Direction view(double zenith_deg, double from_sun_deg) {
  return direction_from(from_degrees(zenith_deg), from_degrees(from_sun_deg));
}

// Computed by hand from the tables, sun at 58.4 deg: Y/Yz at four points, and the zenith's Yz, x, y.
TEST(PreethamSky, GivesTheRecomputedVectors) {
  struct Row {
    double t, yz, x, y, ratio[4];
  };
  constexpr Row rows[] = {{2, 3.580155, .237755, .241414, {2.220509, 1.817507, 1.572763, 4.304686}},
                          {3, 5.346375, .244530, .251840, {1.969965, 1.185682, .993941, 1.385210}},
                          {5, 8.603680, .258032, .271526, {1.807052, .924562, .724793, .728818}},
                          {9, 14.050293, .284848, .306237, {1.583179, .826897, .570212, .468819}}};
  for (const Row& row : rows) {
    const PreethamSky model(Turbidity{row.t}, direction_from(kSunZenith, {0.0}));
    EXPECT_NEAR(model.zenith_luminance(), row.yz, 1e-6);
    const glm::dvec3 zenith = model.luminance_and_chromaticity({0.0, 0.0, 1.0});
    EXPECT_NEAR(zenith.y, row.x, 1e-6);
    EXPECT_NEAR(zenith.z, row.y, 1e-6);
    EXPECT_NEAR(model.luminance_ratio(view(30, 0)), row.ratio[0], 1e-6);
    EXPECT_NEAR(model.luminance_ratio(view(60, 90)), row.ratio[1], 1e-6);
    EXPECT_NEAR(model.luminance_ratio(view(60, 180)), row.ratio[2], 1e-6);
    EXPECT_NEAR(model.luminance_ratio(view(85, 180)), row.ratio[3], 1e-6);
  }
}

TEST(PreethamSky, AgreesWithAnImplementationWrittenSeparatelyFromThePaper) {
  for (int i = 0; i < 500; ++i) {
    const auto u = [i](std::uint64_t j) { return test::hashed_uniform(j, static_cast<std::uint64_t>(i)); };
    const double t = 1.7 + 18.3 * u(1);
    const Direction sun = direction_from({1.4 * u(2)}, {6.0 * u(3)}), d = direction_from({1.5 * u(4)}, {6.0 * u(5)});
    const glm::dvec3 ours = PreethamSky(Turbidity{t}, sun).luminance_and_chromaticity(d);
    const glm::dvec3 theirs =
        test::preetham_yxy(t, zenith_angle(d).value, zenith_angle(sun).value, angle_between(d, sun).value);
    for (int c = 0; c < 3; ++c) {
      const double expected = c == 0 ? std::max(0.0, theirs.x) : theirs[c];  // negative luminance is clamped to 0
      EXPECT_NEAR(ours[c], expected, 1e-9 * std::abs(theirs[c]));
    }
  }
}

TEST(PreethamSky, IsSymmetricUnderASunAtTheZenith) {
  const PreethamSky model(Turbidity{3.0}, {0.0, 0.0, 1.0});
  for (double azimuth = 0.0; azimuth < 360.0; azimuth += 30.0)
    EXPECT_NEAR(model.luminance_ratio(view(50, azimuth)), model.luminance_ratio(view(50, 0)), 1e-12);
}

TEST(PreethamSky, StaysPositiveAndFiniteOverItsWholeRange) {
  for (double t = 0.5; t <= 25.0; t += 0.25)
    for (double sun = 0.0; sun < 90.0; sun += 7.0)
      for (double zenith = 0.0; zenith <= 95.0; zenith += 5.0) {
        const double ratio =
            PreethamSky(Turbidity{t}, direction_from(from_degrees(sun), {0.0})).luminance_ratio(view(zenith, 40));
        EXPECT_TRUE(std::isfinite(ratio) && ratio > 0.0) << t << " " << sun << " " << zenith;
      }
}

TEST(PreethamSky, TakesTheHorizonsValueBelowTheHorizon) {
  const PreethamSky model(Turbidity{4.0}, direction_from(from_degrees(50), {0.0}));
  const Radians gamma = from_degrees(40);
  EXPECT_DOUBLE_EQ(model.luminance_ratio(-0.3, gamma), model.luminance_ratio(0.0, gamma));
  EXPECT_DOUBLE_EQ(model.luminance_ratio(0.0, gamma), model.luminance_ratio(kSmallestCosine, gamma));
}

TEST(PreethamSky, RelativeXyzIsAbsoluteXyzOverTheZenithsLuminance) {
  const PreethamSky model(Turbidity{4.0}, direction_from(from_degrees(50), {0.0}));
  const Direction d = view(60, 70);
  const glm::dvec3 absolute = model.xyz(d), relative = model.relative_xyz(d);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(absolute[c], relative[c] * model.zenith_luminance(), 1e-12);
}

// Illuminant D65: x 0.3127, y 0.3290 is X 0.9505, Z 1.0891 at Y 1 (IEC 61966-2-1).
TEST(PreethamSky, TurnsYxyIntoXyz) {
  const glm::dvec3 xyz = xyz_of({1.0, 0.3127, 0.3290});
  EXPECT_NEAR(xyz.x, 0.9505, 2e-4);
  EXPECT_NEAR(xyz.z, 1.0891, 2e-4);
}

}  // namespace
}  // namespace kasumi
