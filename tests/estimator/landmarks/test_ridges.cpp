// Hillsides under a ridge as landmarks.
#include <gtest/gtest.h>

#include "tests/estimator/landmarks/generated_landmarks.hpp"

namespace kasumi {
namespace {

TEST(RidgeStrip, HoldsThePixelsBelowItsLine) {
  const RidgeStrip ridge{{{10.0, 20.0}, {20.0, 30.0}, {40.0, 30.0}}, 4.0};
  EXPECT_FALSE(ridge.contains(15, 25)) << "the ridge itself shows sky, too";
  EXPECT_FALSE(ridge.contains(15, 26));
  EXPECT_TRUE(ridge.contains(15, 27));
  EXPECT_TRUE(ridge.contains(15, 30));
  EXPECT_FALSE(ridge.contains(15, 31));
  EXPECT_TRUE(ridge.contains(40, 33));
  EXPECT_FALSE(ridge.contains(41, 33));
  EXPECT_FALSE(ridge.contains(9, 23));
  const auto bounds = ridge.bounds();
  int inside = 0;
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 60; ++x) {
      if (!ridge.contains(x, y)) continue;
      ++inside;
      EXPECT_TRUE(x >= bounds.x && x < bounds.x + bounds.width && y >= bounds.y && y < bounds.y + bounds.height)
          << x << ", " << y;
    }
  EXPECT_EQ(inside, 31 * 4);
}

TEST(RidgeStrip, ALevelOneReadsAsABoxOfTheSamePixels) {
  const auto view = generated_view(21);
  auto strips = view.landmarks;
  for (auto& landmark : strips) {
    const auto& box = landmark.surface;
    landmark.ridge = RidgeStrip{{{box.x, box.y - 1.5}, {box.x + box.width - 1.0, box.y - 1.5}}, 1.0 * box.height};
    landmark.surface = landmark.ridge->bounds();
  }
  const auto encoded = encoded_under(view, 3.1, {33, 170}, 1);
  const LandmarkWatch boxes(view.camera.camera, kValley_m, view.landmarks);
  const LandmarkWatch ridges(view.camera.camera, kValley_m, strips);
  const auto by_box = boxes.read(view.camera.camera, encoded), by_ridge = ridges.read(view.camera.camera, encoded);
  for (std::size_t i = 0; i < by_box.size(); ++i) {
    ASSERT_EQ(by_box[i].usable, by_ridge[i].usable) << by_ridge[i].reason;
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(by_box[i].contrast[c], by_ridge[i].contrast[c], 1e-4);
  }
}

// A sloping hillside before the sky, read by a strip that follows it; a box of the same extent would show sky.
TEST(RidgeStrip, FollowsASlope) {
  Camera camera;
  camera.width = 120;
  camera.height = 80;
  ContrastLandmark landmark;
  landmark.distance_m = 3000.0;
  landmark.ridge = RidgeStrip{{{10.0, 30.0}, {110.0, 60.0}}, 6.0};
  landmark.surface = landmark.ridge->bounds();
  landmark.sky = LandmarkBox{40, 2, 40, 10};
  Image<glm::vec3> encoded(120, 80);
  for (int y = 0; y < 80; ++y)
    for (int x = 0; x < 120; ++x) {
      const double light = y > 27.0 + 0.3 * x ? 0.2 : 0.5;
      encoded.at(x, y) = glm::vec3(camera.response.to_encoded(glm::dvec3(light)));
    }
  const auto reading = read_contrasts(camera, encoded, {landmark}).front();
  ASSERT_TRUE(reading.usable) << reading.reason;
  EXPECT_NEAR(reading.contrast.g, 0.6, 0.002);
  auto box = landmark;
  box.ridge.reset();
  EXPECT_LT(read_contrasts(camera, encoded, {box}).front().contrast.g, 0.55);
}

}  // namespace
}  // namespace kasumi
