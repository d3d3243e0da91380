// The horizon's light under broken clouds, in synthetic telephoto views with a known clear sky.
#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "estimator/horizon/clear_horizon.hpp"
#include "estimator/horizon/horizon.hpp"
#include "tests/estimator/horizon/drawn_scene.hpp"
#include "tests/must.hpp"

namespace kasumi {
namespace {

// 6 deg wide, from .6 deg below the horizon upwards.
Camera tele_camera() {
  Camera camera = drawn_camera(1.1);
  PinholeParameters pinhole;
  pinhole.focal_px = {6100.0, 6100.0};
  pinhole.centre = {319.5, 179.5};
  camera.lens = pinhole_lens(pinhole);
  return camera;
}

// Streaks 1/6 deg thick, seen through air that removes most of their blue. `cover`: 0..1.
glm::dvec3 with_streaks(const Direction& direction, double cover) {
  const double elevation = 90.0 - to_degrees(zenith_angle(direction));
  const double azimuth = std::remainder(to_degrees(azimuth_angle(direction)) - 20.0, 360.0);
  const double wave = 0.5 * std::sin(17.0 * elevation + 0.8 * azimuth) + 0.3 * std::sin(41.0 * elevation - azimuth) +
                      0.2 * std::sin(1.1 * azimuth + 5.0 * elevation);
  const double opacity = std::clamp(0.5 + 4.0 * (wave + 1.1 * (cover - 0.5)), 0.0, 1.0);
  return drawn_sky(direction) * (1.0 + opacity * (0.8 + 0.5 * wave) * glm::dvec3{0.16, 0.09, 0.02});
}

// A ridge 30 to 50 km away whose sunlit slopes have almost faded, and a nearer one.
std::function<glm::dvec3(int, int)> ridges(const Camera& camera) {
  return [&camera](int x, int y) {
    const Direction direction = *camera.direction_at({x, y});
    if (y > 262 + 9.0 * std::sin(0.013 * x)) return glm::dvec3{0.75, 0.82, 0.9} * drawn_sky(direction);
    if (y > 205 + 14.0 * std::sin(0.011 * x + 1.0) + 4.0 * std::sin(0.05 * x))
      return glm::dvec3{0.94, 0.97, 0.99} * drawn_sky(direction);
    return glm::dvec3{-1.0};
  };
}

TEST(HorizonUnderClouds, IsTheClearSkysBetweenTheStreaks) {
  const Camera camera = tele_camera();
  for (const double cover : {0.0, 0.2, 0.4, 0.55}) {
    DrawnOptions options;
    options.noise = 1.5;
    options.sky = [&](const Direction& direction) { return with_streaks(direction, cover); };
    options.front = ridges(camera);
    const DrawnScene scene = draw(camera, options);
    const HorizonLight horizon = measure_horizon(camera, view_of(scene.picture));
    ASSERT_TRUE(horizon.usable()) << horizon.reason;
    EXPECT_EQ(horizon.columns.size(), 16U) << cover;
    EXPECT_EQ(horizon.reason, "") << cover;
    EXPECT_LT(worst_light_error(horizon), 0.008) << cover;  // streaks are up to 18 %, the far ridge 6 % off
  }
}

// As at dusk: noise hides the far ridge's edge from the rows of a strip, but not from larger cells.
TEST(HorizonUnderClouds, IsTheClearSkysAboveFadedRidgesInANoisyPicture) {
  const Camera camera = tele_camera();
  for (const double noise : {3.0, 4.0}) {
    DrawnOptions options;
    options.noise = noise;
    options.front = ridges(camera);
    const DrawnScene scene = draw(camera, options);
    const HorizonLight horizon = measure_horizon(camera, view_of(scene.picture));
    ASSERT_TRUE(horizon.usable()) << horizon.reason;
    EXPECT_EQ(horizon.reason, "") << noise;
    EXPECT_LT(worst_light_error(horizon), 0.012) << noise;
  }
}

TEST(HorizonUnderClouds, IsFoundBelowABankThatReachesThePicturesTop) {
  const Camera camera = tele_camera();
  DrawnOptions options;
  options.noise = 1.5;
  options.sky = [](const Direction& direction) {
    const double elevation = 90.0 - to_degrees(zenith_angle(direction));
    const double edge = 2.3 + 0.1 * std::sin(80.0 * direction.x), streak = std::abs(elevation - 1.6);
    const double cloud = std::clamp((elevation - edge) / 0.02, 0.0, 1.0) + std::clamp((0.1 - streak) / 0.02, 0.0, 1.0);
    const double billows = 1.0 + 0.3 * std::sin(300.0 * direction.x) * std::sin(900.0 * direction.z);
    return drawn_sky(direction) * (1.0 + billows * cloud * glm::dvec3{0.2, 0.12, 0.04});
  };
  options.front = ridges(camera);
  const HorizonLight horizon = measure_horizon(camera, view_of(draw(camera, options).picture));
  ASSERT_TRUE(horizon.usable()) << horizon.reason;
  EXPECT_LT(worst_light_error(horizon), 0.008);
}

TEST(HorizonUnderClouds, UsesTheLowestSkyWhereNothingIsClearAndReportsIt) {
  const Camera camera = tele_camera();
  DrawnOptions options;
  options.sky = [](const Direction& direction) {  // billows everywhere, +-25 %
    return drawn_sky(direction) *
           (1.0 + 0.15 * std::sin(180.0 * direction.x) + 0.1 * std::sin(450.0 * direction.z + 90.0 * direction.x));
  };
  const HorizonLight horizon = measure_horizon(camera, view_of(draw(camera, options).picture));
  ASSERT_TRUE(horizon.usable());
  EXPECT_EQ(horizon.reason, "little clear sky at the horizon: the lowest sky is used, including clouds");
  EXPECT_LT(worst_light_error(horizon), 0.3);  // within what the billows show
}

double uniform(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11) * 0x1p-53;
}

// Cells of a known surface, a share of them up to 20 % brighter in red and less so in blue.
std::vector<HorizonCell> drawn_cells(double cloudy, std::mt19937_64& random) {
  std::vector<HorizonCell> cells;
  for (int i = 0; i < 2000; ++i) {
    HorizonCell cell;
    cell.azimuth = 0.1 * (uniform(random) - 0.5);
    cell.elevation = 0.05 * uniform(random);
    cell.strip = std::min(15, static_cast<int>(160.0 * (cell.azimuth + 0.05)));
    cell.noise = 0.002;
    const double surface = -1.0 + 0.4 * cell.azimuth + 3.0 * cell.azimuth * cell.azimuth - 0.8 * cell.elevation;
    cell.log_light = glm::dvec3{surface, surface + 0.2, surface + 0.1};
    for (int c = 0; c < 3; ++c) cell.log_light[c] += cell.noise * 3.46 * (uniform(random) - 0.5);
    if (uniform(random) < cloudy) cell.log_light += 0.2 * uniform(random) * glm::dvec3{1.0, 0.6, 0.15};
    cells.push_back(cell);
  }
  return cells;
}

TEST(ClearHorizon, GoesThroughTheClearCellsWhenMostAreCloud) {
  std::mt19937_64 random(11);
  for (const double cloudy : {0.0, 0.3, 0.6, 0.7}) {
    const auto cells = drawn_cells(cloudy, random);
    const auto clear = must(fit_clear_horizon(cells, std::vector<std::uint8_t>(cells.size(), 1)));
    EXPECT_NEAR(clear->share, 1.0 - cloudy, 0.06);  // including clouds too thin to be detected
    for (const double azimuth : {-0.04, 0.0, 0.04}) {
      for (const double elevation : {0.005, 0.025, 0.045}) {
        const double truth = -1.0 + 0.4 * azimuth + 3.0 * azimuth * azimuth - 0.8 * elevation;
        const glm::dvec3 found = clear->log_light(azimuth, elevation);
        EXPECT_NEAR(found.x, truth, 0.003) << cloudy;
        EXPECT_NEAR(found.y, truth + 0.2, 0.003) << cloudy;
        EXPECT_NEAR(found.z, truth + 0.1, 0.003) << cloudy;
      }
    }
  }
}

TEST(ClearHorizon, LooksOnlyAtTheCellsInUse) {
  std::mt19937_64 random(12);
  auto cells = drawn_cells(0.0, random);
  std::vector<std::uint8_t> use(cells.size(), 1);
  for (std::size_t i = 0; i < cells.size(); i += 2) {
    use[i] = 0;
    cells[i].log_light += glm::dvec3{0.03};
  }
  const auto clear = must(fit_clear_horizon(cells, use));
  EXPECT_NEAR(clear->log_light(0.0, 0.0).x, -1.0, 0.002);
}

TEST(ClearHorizon, NeedsSixteenCellsThatAreNotLostInNoise) {
  std::mt19937_64 random(13);
  auto cells = drawn_cells(0.0, random);
  std::vector<std::uint8_t> use(cells.size(), 0);
  std::fill(use.begin(), use.begin() + 15, std::uint8_t{1});
  EXPECT_FALSE(fit_clear_horizon(cells, use));
  use[15] = 1;
  EXPECT_TRUE(fit_clear_horizon(cells, use));
  for (HorizonCell& cell : cells) cell.noise = 0.02;
  EXPECT_FALSE(fit_clear_horizon(cells, use));
}

}  // namespace
}  // namespace kasumi
