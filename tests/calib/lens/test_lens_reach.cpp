// Outside a model's domain there is no result, rather than one from a wrong branch.
#include <limits>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "base/geometry.hpp"
#include "tests/calib/lens/lenses.hpp"

namespace kasumi {
namespace {

glm::dvec3 ray_off_axis(Radians angle) {
  return {std::sin(angle.value), 0.0, std::cos(angle.value)};
}

TEST(LensReach, AFisheyeEndsAtItsLargestAngleAndIncludesTheRim) {
  const auto largest = from_degrees(92.0);
  const std::vector<LensPtr> lenses{equidistant_lens({200.0, 200.0}, 100.0, largest),
                                    equisolid_lens({200.0, 200.0}, 100.0, largest),
                                    opencv_fisheye_lens({100.0, 100.0}, {200.0, 200.0}, {0.01, 0.0, 0.0, 0.0}, largest),
                                    scaramuzza_lens(sample_scaramuzza(), largest)};
  for (const auto& lens : lenses) {
    const auto rim = lens->project(ray_off_axis(largest));
    ASSERT_TRUE(rim) << lens->name();
    EXPECT_TRUE(lens->unproject(*rim)) << lens->name();
    EXPECT_FALSE(lens->project(ray_off_axis(from_degrees(92.01)))) << lens->name();
    EXPECT_FALSE(lens->unproject({rim->x + 0.1, rim->y})) << lens->name();
  }
}

TEST(LensReach, WhereTheFisheyePolynomialTurnsBackTheModelEnds) {
  // theta_d = theta - theta^3 / 3 has its maximum 2/3 at theta = 1.
  const auto lens = opencv_fisheye_lens({300.0, 300.0}, {0.0, 0.0}, {-1.0 / 3.0, 0.0, 0.0, 0.0}, from_degrees(120.0));
  EXPECT_TRUE(lens->project(ray_off_axis({0.9999})));
  EXPECT_FALSE(lens->project(ray_off_axis({1.001})));
  EXPECT_TRUE(lens->unproject({199.99, 0.0}));
  EXPECT_FALSE(lens->unproject({200.1, 0.0}));
  for (double r = 0.0; r < 199.9; r += 0.7)
    EXPECT_LT(angle_between(lens->unproject({r, 0.0}).value(), {0.0, 0.0, 1.0}).value, 1.0);
}

TEST(LensReach, AScaramuzzaModelEndsWhereTwoRadiiShareOneAngle) {
  // forward = 100 + rho^2 / 400: theta grows until forward = rho forward', at rho = 200, theta = 45 deg.
  const auto lens = scaramuzza_lens({{-100.0, 0.0, -1.0 / 400.0}, {0.0, 0.0}}, from_degrees(90.0));
  for (double r = 1.0; r < 199.9; r += 0.9) {
    const auto ray = lens->unproject({r, 0.0});
    ASSERT_TRUE(ray);
    EXPECT_NEAR(ray->x / ray->z, r / (100.0 + r * r / 400.0), 1e-12);
    EXPECT_NEAR(lens->project(*ray)->x, r, 1e-6);
  }
  EXPECT_FALSE(lens->unproject({200.1, 0.0}));
  EXPECT_FALSE(lens->project(ray_off_axis(from_degrees(45.1))));
}

TEST(LensReach, APinholeEndsWhereBarrelDistortionFoldsTheImage) {
  // r (1 - r^2 / 3) has its maximum 2/3 at r = 1.
  const auto lens = pinhole_lens({{300.0, 300.0}, {0.0, 0.0}, {-1.0 / 3.0, 0.0, 0.0, 0.0, 0.0}});
  EXPECT_TRUE(lens->project({0.99, 0.0, 1.0}));
  EXPECT_FALSE(lens->project({1.01, 0.0, 1.0}));
  EXPECT_FALSE(lens->project({1.8, 0.0, 1.0}));  // distorted back into the image
  for (double r = 0.0; r < 199.9; r += 0.7) {
    const auto ray = lens->unproject({0.0, r});
    ASSERT_TRUE(ray) << r;
    EXPECT_LT(ray->y / ray->z, 1.0);
  }
  EXPECT_FALSE(lens->unproject({0.0, 200.1}));
  EXPECT_FALSE(lens->unproject({5000.0, 0.0}));
}

TEST(LensReach, StrongTangentialDistortionNeverMapsTwoRaysToOnePixel) {
  const auto lens = pinhole_lens({{300.0, 300.0}, {0.0, 0.0}, {-0.2, 0.03, 0.06, -0.04, 0.0}});
  int seen = 0;
  for (double y = -2.0; y <= 2.0; y += 0.05)
    for (double x = -2.0; x <= 2.0; x += 0.05) {
      const auto pixel = lens->project({x, y, 1.0});
      if (!pixel) continue;
      ++seen;
      const auto ray = lens->unproject(*pixel);
      ASSERT_TRUE(ray) << x << ", " << y;
      EXPECT_NEAR(ray->x / ray->z, x, 1e-7);
      EXPECT_NEAR(ray->y / ray->z, y, 1e-7);
    }
  EXPECT_GT(seen, 500);
}

TEST(LensReach, NothingIsVisibleBehindAPinholeOrStraightBehindAFisheye) {
  const auto pinhole = pinhole_lens(sample_pinhole());
  EXPECT_FALSE(pinhole->project({0.1, 0.1, -1.0}));
  EXPECT_FALSE(pinhole->project({1.0, 0.0, 0.0}));
  const auto fisheye = equidistant_lens({}, 100.0, from_degrees(180.0));
  EXPECT_FALSE(fisheye->project({0.0, 0.0, -1.0}));
  EXPECT_TRUE(fisheye->project({1e-3, 0.0, -1.0}));
}

TEST(LensReach, ZeroRaysAndNonFiniteNumbersAreNotProjected) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  for (const auto& [what, lens, width, height] : sample_lenses()) {
    EXPECT_FALSE(lens->project({0.0, 0.0, 0.0})) << what;
    EXPECT_FALSE(lens->project({nan, 0.0, 1.0})) << what;
    EXPECT_FALSE(lens->project({0.0, 0.1, nan})) << what;
    EXPECT_FALSE(lens->unproject({nan, 0.0})) << what;
    EXPECT_FALSE(lens->unproject({inf, 0.0})) << what;
  }
}

}  // namespace
}  // namespace kasumi
