#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <glm/exponential.hpp>

#include "estimator/photograph/facade.hpp"
#include "tests/must.hpp"

namespace kasumi {
namespace {

// A facade of known light through known air: M Eq 12, written out here once more.
FacadeView seen_through(double depth_green, double sunlit) {
  FacadeView view;
  view.light = Image<glm::vec3>(4, 3);
  view.sky = {{0.5, 0.6, 0.7}, {0.002, 0.002, 0.001}, glm::dvec3(1e-6)};
  view.depth = depth_green * glm::dvec3{0.8, 1.0, 1.3};
  view.depth_sigma = 0.05 * view.depth;
  view.sunlit = sunlit;
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 4; ++x)
      for (int c = 0; c < 3; ++c) {
        const double infinity = view.sky.light[c] + y * view.sky.per_row[c], gamma = std::exp(-view.depth[c]);
        const double own = 0.05 + 0.02 * x + 0.3 * sunlit;
        view.light.at(x, y)[c] = static_cast<float>(infinity * (1.0 - gamma) + gamma * own * infinity);
      }
  return view;
}

TEST(Facade, IsMeasuredInClearAirAndDrawnAsItWouldBeSeenInHaze) {
  std::vector<FacadeView> views;
  for (const double depth : {0.1, 0.15, 0.2}) views.push_back(seen_through(depth, 0.0));
  for (const double sunlit : {0.4, 0.6, 0.8}) views.push_back(seen_through(0.12, sunlit));
  std::vector<const FacadeView*> all;
  for (const auto& view : views) all.push_back(&view);
  const auto facade = must(measure_facade(all));
  EXPECT_EQ(facade->shaded_views, 3);
  EXPECT_EQ(facade->lit_views, 3);
  EXPECT_NEAR(facade->shade.at(3, 1).g, 0.11, 1e-4);
  EXPECT_NEAR(facade->lit.at(0, 2).r, 0.3, 1e-3);
  for (const double sunlit : {0.0, 0.5}) {
    const auto hazy = seen_through(1.4, sunlit);
    const auto drawn = put_back(*facade, hazy.sky, hazy.depth, sunlit);
    for (std::size_t i = 0; i < drawn.elements().size(); ++i)
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(drawn.elements()[i][c], hazy.light.elements()[i][c], 2e-4);
  }
}

TEST(Facade, ASigmaOfTheAirIsOneOfTheDrawing) {
  std::vector<FacadeView> views{seen_through(0.1, 0.0), seen_through(0.1, 0.0), seen_through(0.1, 0.0)};
  const auto facade = must(measure_facade({&views[0], &views[1], &views[2]}));
  const auto hazy = seen_through(1.0, 0.0);
  const auto more = put_back(*facade, hazy.sky, hazy.depth + hazy.depth_sigma, 0.0);
  const auto less = put_back(*facade, hazy.sky, hazy.depth - hazy.depth_sigma, 0.0);
  const auto half = 0.5 * (mean_of(more) - mean_of(less)), sigma = put_back_sigma(*facade, hazy);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(sigma[c], half[c], 0.05 * half[c] + 5e-4);
}

TEST(Facade, TooFewViewsInTheShadeMeasureNothing) {
  const auto lit = seen_through(0.1, 0.5), shaded = seen_through(0.1, 0.0);
  EXPECT_FALSE(measure_facade({&lit, &lit, &lit}));
  EXPECT_FALSE(measure_facade({&shaded, &shaded}));
}

}  // namespace
}  // namespace kasumi
