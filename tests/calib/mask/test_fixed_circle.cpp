#include <gtest/gtest.h>

#include "calib/mask/fixed_circle.hpp"

namespace kasumi {
namespace {

SizedCircle picture_with(double x, double y, double radius, double confidence, int width = 640) {
  FoundCircle found;
  found.circle = {{x, y}, radius, 1.0};
  found.confidence = confidence;
  found.others = {{found.circle, confidence}};
  return {width, 480, found};
}

TEST(FixedCircle, OneThatIsUnsureFollowsTheOthers) {
  const auto circles = circles_of_fixed_cameras(
      {picture_with(320.0, 240.0, 200.0, 0.9), picture_with(321.0, 241.0, 201.0, 0.8),
       picture_with(320.5, 239.0, 200.5, 0.9), picture_with(300.0, 200.0, 150.0, 0.2), SizedCircle{640, 480, {}}});
  for (const auto& circle : circles) {
    ASSERT_TRUE(circle);
    EXPECT_NEAR(circle->circle.radius_px, 200.5, 0.6);
    EXPECT_NEAR(circle->circle.centre.y, 240.0, 1.1);
  }
  EXPECT_GT(circles[0]->confidence, 0.8);
  EXPECT_LT(circles[4]->confidence, 0.5) << "nothing in the picture itself speaks for it";
}

TEST(FixedCircle, OneBadlySeenAmongManyFollowsThem) {
  std::vector<SizedCircle> pictures(5, picture_with(320.0, 240.0, 200.0, 0.9));
  pictures.push_back(picture_with(328.0, 240.0, 195.0, 0.7));
  pictures.back().found->others.push_back({{{320.5, 240.0}, 200.5, 1.0}, 0.4});
  const auto circles = circles_of_fixed_cameras(pictures);
  EXPECT_NEAR(circles.back()->circle.centre.x, 320.0, 1.0);
}

TEST(FixedCircle, OtherCamerasAndMovedCropsKeepTheirs) {
  const auto circles =
      circles_of_fixed_cameras({picture_with(320.0, 240.0, 200.0, 0.9), picture_with(320.0, 240.0, 200.0, 0.9),
                                picture_with(320.0, 240.0, 200.0, 0.9), picture_with(350.0, 240.0, 200.0, 0.9),
                                picture_with(350.0, 241.0, 200.0, 0.9), picture_with(300.0, 230.0, 120.0, 0.8),
                                picture_with(200.0, 240.0, 160.0, 0.2, 500)});
  EXPECT_NEAR(circles[0]->circle.centre.x, 320.0, 0.1);
  EXPECT_NEAR(circles[4]->circle.centre.x, 350.0, 0.1) << "moved";
  EXPECT_NEAR(circles[5]->circle.radius_px, 120.0, 0.1) << "another lens";
  EXPECT_NEAR(circles[6]->circle.radius_px, 160.0, 0.1) << "another size";
  EXPECT_NEAR(circles[6]->confidence, 0.2, 1e-9);
}

TEST(FixedCircle, OfOnePictureAndOfNoneNothingChanges) {
  EXPECT_TRUE(circles_of_fixed_cameras({}).empty());
  const auto circles = circles_of_fixed_cameras({picture_with(320.0, 240.0, 200.0, 0.6), SizedCircle{}});
  EXPECT_NEAR(circles[0]->confidence, 0.6, 1e-9);
  EXPECT_FALSE(circles[1]);
}

}  // namespace
}  // namespace kasumi
