// What is kept of a view shows where its lines are, and not which side of them is bright.
#include <gtest/gtest.h>

#include <cmath>

#include <glm/mat3x3.hpp>

#include "calib/pose/view_lines.hpp"
#include "calib/pose/view_turn.hpp"

namespace kasumi {
namespace {

constexpr int kWidth = 160, kHeight = 120;
const Lens& lens() {
  static const auto made = pinhole_lens({.focal_px = {150.0, 150.0}, .centre = {79.5, 59.5}, .distortion = {}});
  return *made;
}

// Bright discs on grey, seen by a camera that has turned to the left.
ShrunkView discs(double bright, double turn = 0.0) {
  const glm::dmat3 back{{std::cos(turn), 0.0, std::sin(turn)}, {0.0, 1.0, 0.0}, {-std::sin(turn), 0.0, std::cos(turn)}};
  ShrunkView view{Image<float>(kWidth, kHeight), 1, {}};
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const auto from = *lens().project(back * *lens().unproject({x, y}));
      double light = 0.5;
      for (int j = 0; j < 4; ++j)
        for (int i = 0; i < 5; ++i) {
          const double away = std::hypot(from.x - 18.0 - 30.0 * i - 5.0 * (j % 2), from.y - 18.0 - 28.0 * j);
          light += bright / (1.0 + std::exp(2.0 * (away - 6.0 - i)));
        }
      view.light.at(x, y) = static_cast<float>(light);
    }
  return view;
}

TEST(ViewLines, APictureAndItsNegativeLeaveTheSame) {
  const auto one = lines_of(lens(), discs(0.3)), other = lines_of(lens(), discs(-0.3));
  int different = 0, drawn = 0;
  for (std::size_t i = 0; i < one.strength.elements().size(); ++i) {
    drawn += one.strength.elements()[i] > 0;
    different += std::abs(int{one.strength.elements()[i]} - int{other.strength.elements()[i]}) > 2;
  }
  EXPECT_GT(drawn, 2000);
  EXPECT_LT(100 * different, drawn) << "nothing tells a light coat from a dark one";
}

TEST(ViewLines, EvenPartsLeaveNothing) {
  const auto lines = lines_of(lens(), discs(0.0));
  for (const auto strength : lines.strength.elements()) ASSERT_EQ(strength, 0);
}

TEST(ViewLines, ATurnIsFoundByThem) {
  constexpr double kTurn = 0.01, kTenthOfAPixel = 0.1 / 150.0;
  for (const double bright : {0.2, -0.2}) {
    const auto turn = find_turn(lens(), lines_of(lens(), discs(0.3)), lines_of(lens(), discs(bright, kTurn)));
    ASSERT_TRUE(turn);
    EXPECT_NEAR(turn->turn.y, kTurn, kTenthOfAPixel) << "under other light: " << bright;
    EXPECT_NEAR(turn->turn.x, 0.0, kTenthOfAPixel);
  }
}

}  // namespace
}  // namespace kasumi
