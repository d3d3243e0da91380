// Completing measured range maps: synthetic maps with known truth.
#include <cmath>
#include <limits>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estimator/haze/range.hpp"
#include "tests/must.hpp"

namespace kasumi {
namespace {

// A slanted wall: planar depth of a plane in space, 1 / z linear across the picture.
double slanted_wall_m(double x, double y) {
  return 1.0 / (0.2 - 0.0008 * x + 0.0004 * y);
}
Image<float> slanted_wall(int width, int height) {
  Image<float> range(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) range.at(x, y) = static_cast<float>(slanted_wall_m(x, y));
  return range;
}
RangeRules indoors() {
  RangeRules options;
  options.smallest_sky_share = 1.0;
  return options;
}

TEST(HazeRange, AHoleInASlantedWallIsFilledByTheWall) {
  auto range = slanted_wall(120, 90);
  for (int y = 30; y < 55; ++y)
    for (int x = 40; x < 80; ++x) range.at(x, y) = 0.0F;
  range.at(3, 3) = 0.0F;
  const auto made = must(prepare_range(range, indoors()));
  EXPECT_EQ(made->holes, 2);
  EXPECT_NEAR(made->hole_share, (25.0 * 40.0 + 1.0) / (120.0 * 90.0), 1e-9);
  double worst = 0.0;
  for (int y = 0; y < 90; ++y)
    for (int x = 0; x < 120; ++x) {
      const double metres = static_cast<double>(made->range.at(x, y)) * made->farthest_m;
      worst = std::max(worst, std::abs(metres / slanted_wall_m(x, y) - 1.0));
    }
  EXPECT_LT(worst, 1e-4) << "of the range";
}

// However small its share; a hole of the wall beside it stays a hole.
TEST(HazeRange, InfinityIsSkyAndIndoorsAHole) {
  auto range = slanted_wall(120, 90);
  for (int y = 0; y < 4; ++y)
    for (int x = 10; x < 14; ++x) range.at(x, y) = std::numeric_limits<float>::infinity();
  range.at(60, 40) = 0.0F;
  RangeRules options;
  options.margin_px = 0;
  const auto outdoors = must(prepare_range(range, options));
  EXPECT_EQ(outdoors->holes, 1);
  EXPECT_NEAR(outdoors->sky_share, 16.0 / (120.0 * 90.0), 1e-9);
  EXPECT_EQ(outdoors->sky.at(11, 1), 255);
  EXPECT_EQ(outdoors->sky.at(60, 40), 0);
  EXPECT_EQ(outdoors->range.at(11, 1), static_cast<float>(options.sky_range));
  EXPECT_NEAR(outdoors->farthest_m, slanted_wall_m(119, 0), 1e-4);
  const auto room = must(prepare_range(range, indoors()));
  EXPECT_EQ(room->holes, 2);
  EXPECT_EQ(room->sky_share, 0.0);
  EXPECT_NEAR(static_cast<double>(room->range.at(11, 1)) * room->farthest_m, slanted_wall_m(11, 1), 1e-3);
}

TEST(HazeRange, AHoleWhoseBorderIsPartlyAnObjectInFrontIsFilledByTheWallBehind) {
  // A third of the border is a post at 2 m, and a few returns are outliers.
  auto range = slanted_wall(120, 90);
  for (int y = 20; y < 70; ++y)
    for (int x = 30; x < 40; ++x) range.at(x, y) = 2.0F;
  for (int y = 25; y < 65; ++y)
    for (int x = 40; x < 75; ++x) range.at(x, y) = 0.0F;
  std::mt19937_64 random(5);
  for (int i = 0; i < 12; ++i) range.at(40 + static_cast<int>(random() % 35), 24) = 0.5F + 0.1F * static_cast<float>(i);
  const auto made = must(prepare_range(range, indoors()));
  double worst = 0.0;
  for (int y = 25; y < 65; ++y)
    for (int x = 40; x < 75; ++x)
      worst = std::max(
          worst, std::abs(static_cast<double>(made->range.at(x, y)) * made->farthest_m / slanted_wall_m(x, y) - 1.0));
  EXPECT_LT(worst, 2e-3) << "of the range";
}

TEST(HazeRange, MeasuredRangesStayUnchanged) {
  auto range = slanted_wall(100, 80);
  for (int x = 0; x < 100; ++x)
    for (int y = 0; y < 20 + x / 10; ++y) range.at(x, y) = 0.0F;  // sky
  for (int x = 30; x < 36; ++x) range.at(x, 60) = 0.0F;           // hole
  const auto made = must(prepare_range(range));
  for (int y = 0; y < 80; ++y)
    for (int x = 0; x < 100; ++x)
      if (range.at(x, y) > 0.0F) {
        ASSERT_FLOAT_EQ(made->range.at(x, y), range.at(x, y) / static_cast<float>(made->farthest_m));
      }
}

TEST(HazeRange, TheLargeUndefinedRegionsAreSkyAndTheSmallOnesAreNot) {
  Image<float> range(200, 100, 50.0F);
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 200; ++x)
      if (x != 120) range.at(x, y) = 0.0F;  // two regions, a mast of one pixel between them
  for (int y = 70; y < 75; ++y)
    for (int x = 50; x < 55; ++x) range.at(x, y) = 0.0F;
  RangeRules options;
  options.sky_range = 1.5;
  const auto made = must(prepare_range(range, options));
  EXPECT_EQ(made->holes, 1);
  EXPECT_NEAR(made->sky_share, 199.0 * 40.0 / (200.0 * 100.0), 1e-9);
  EXPECT_FLOAT_EQ(made->range.at(10, 2), 1.5F);
  EXPECT_FLOAT_EQ(made->range.at(190, 2), 1.5F);
  EXPECT_FLOAT_EQ(made->range.at(52, 72), 1.0F);
  EXPECT_EQ(made->sky.at(52, 72), 0);
  EXPECT_FLOAT_EQ(made->range.at(120, 2), 1.0F);
  const auto inside = must(prepare_range(range, indoors()));
  EXPECT_EQ(inside->holes, 3);
  EXPECT_EQ(inside->sky_share, 0.0);
}

TEST(HazeRange, AboveALevelHorizonTheMarginIsLinear) {
  // Laplace between two parallel lines: linear.
  constexpr int kMargin = 10;
  Image<float> range(60, 60, 0.6F);
  Image<std::uint8_t> sky(60, 60);
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 60; ++x) sky.at(x, y) = 255, range.at(x, y) = 1.2F;
  taper_into_sky(range, sky, 1.2F, kMargin);
  for (int y = 0; y < 60; ++y) {
    const double away = std::clamp((30.0 - y) / kMargin, 0.0, 1.0);
    for (int x = 0; x < 60; ++x) ASSERT_NEAR(range.at(x, y), 0.6 + 0.6 * away, 2e-4) << y;
  }
}

TEST(HazeRange, AroundARoundTreeTheMarginFollowsTheLogarithm) {
  // Laplace between two circles: linear in ln r.
  constexpr double kTree = 30.0;
  constexpr int kMargin = 30;
  Image<float> range(161, 161, 0.5F);
  Image<std::uint8_t> sky(161, 161);
  for (int y = 0; y < 161; ++y)
    for (int x = 0; x < 161; ++x)
      if (std::hypot(x - 80, y - 80) > kTree) sky.at(x, y) = 255, range.at(x, y) = 1.0F;
  taper_into_sky(range, sky, 1.0F, kMargin);
  double worst = 0.0;
  for (int y = 0; y < 161; ++y)
    for (int x = 0; x < 161; ++x) {
      const double r = std::hypot(x - 80, y - 80);
      if (r < kTree + 1.0 || r > kTree + kMargin - 1.0) continue;
      const double truth = 0.5 + 0.5 * std::log(r / kTree) / std::log((kTree + kMargin) / kTree);
      worst = std::max(worst, std::abs(static_cast<double>(range.at(x, y)) - truth));
    }
  EXPECT_LT(worst, 0.02) << "of the farthest range; a circle of pixels is rough by half a pixel";
}

TEST(HazeRange, TheGroundInPerspectiveIsOneSurfaceAndAPostOnItAnother) {
  // R = h f / y below the horizon.
  Image<float> range(80, 120);
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 80; ++x) range.at(x, y) = static_cast<float>(200.0 / (y + 6.0));
  const auto ground = range_steps_down_column(range);
  for (int y = 1; y < 120; ++y) ASSERT_FLOAT_EQ(ground.at(40, y), ground.at(40, 0));
  for (int y = 0; y < 60; ++y)
    for (int x = 30; x < 34; ++x) range.at(x, y) = 2.5F;
  const auto steps = range_steps_along_row(range);
  EXPECT_FLOAT_EQ(steps.at(29, 20), steps.at(0, 20));
  EXPECT_NEAR(steps.at(34, 20), steps.at(29, 20), 1e-5) << "the ground goes on behind the post";
  EXPECT_NEAR(std::abs(steps.at(31, 20) - steps.at(29, 20)),
              static_cast<double>(kRangeStepTurn) - std::log(200.0 / 26.0 / 2.5), 1e-4)
      << "a step towards the camera, modulo the turn";
}

TEST(HazeRange, AnEdgeSmearedOverThreePixelsIsStillAnEdge) {
  Image<float> range(60, 1);
  for (int x = 0; x < 60; ++x) range.at(x, 0) = static_cast<float>(10.0 + 10.0 * std::clamp((x - 29) / 3.0, 0.0, 1.0));
  const auto steps = range_steps_along_row(range);
  EXPECT_NEAR(steps.at(59, 0) - steps.at(0, 0), std::log(2.0), 1e-4);
}

TEST(HazeRange, ReportsEveryProblemOfItsOptions) {
  RangeRules options;
  options.smallest_sky_share = 0.0;
  options.sky_range = 1.0;
  options.margin_px = -1;
  const auto made = prepare_range(Image<float>(4, 4, 1.0F), options);
  ASSERT_FALSE(made);
  EXPECT_THAT(made.error().message,
              testing::AllOf(testing::HasSubstr("share"), testing::HasSubstr("sky"), testing::HasSubstr("margin")));
  const auto nothing = prepare_range(Image<float>(4, 4), {});
  ASSERT_FALSE(nothing);
  EXPECT_EQ(nothing.error().kind, FaultKind::bad_input);
}

}  // namespace
}  // namespace kasumi
