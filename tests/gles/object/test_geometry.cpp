// Geometry of the picture: projection, boxes, letterboxes, division into rectangles, airlight grids.
#include <cmath>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/calib3d.hpp>

#include "gles/gl/target.hpp"
#include "gles/gpu_model/projection.hpp"
#include "gles/light/airlight_grid.hpp"
#include "gles/picture/picture_cutting.hpp"
#include "tests/gles/scenes.hpp"

namespace kasumi {
namespace {

double uniform(std::mt19937_64& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
}

TEST(Projection, AgreesWithOpenCv) {
  std::mt19937_64 random(3);
  SceneView view = view_north(1920, 1080, 1400);
  view.focal_px.y = 1380;
  view.centre_px = {955.2, 551.7};
  view.distortion = {-0.21, 0.06, 0.0011, -0.0007, -0.004};
  const auto projection = make_projection(view, glm::dmat4{1.0});
  ASSERT_OK(projection);
  const cv::Matx33d camera(1400, 0, 955.2, 0, 1380, 551.7, 0, 0, 1);
  for (int i = 0; i < 200; ++i) {
    const double depth = uniform(random, 100, 5000);
    const glm::dvec3 point{uniform(random, -0.65, 0.65) * depth, uniform(random, -0.36, 0.36) * depth, depth};
    std::vector<cv::Point2d> seen;
    cv::projectPoints(std::vector<cv::Point3d>{{point.x, point.y, point.z}}, cv::Vec3d(), cv::Vec3d(), camera,
                      std::vector<double>{-0.21, 0.06, 0.0011, -0.0007, -0.004}, seen);
    const glm::dvec2 ours = pixel_of(*projection, point);
    EXPECT_NEAR(ours.x, seen[0].x, 1e-9) << "pixels";
    EXPECT_NEAR(ours.y, seen[0].y, 1e-9) << "pixels";
  }
}

TEST(Projection, DoesNotFoldPointsOutsideThePictureIntoIt) {
  SceneView view = view_north(640, 480, 650);
  view.distortion = {-0.3, 0.0, 0, 0, 0};  // the polynomial turns back at radius 1.05, and is negative beyond 1.83
  const auto projection = make_projection(view, glm::dmat4{1.0});
  ASSERT_OK(projection);
  double last = 0.0;
  for (double x = 0.0; x < 5.0; x += 0.01) {
    const double pixel = pixel_of(*projection, {100.0 * x, 0.0, 100.0}).x;
    EXPECT_GE(pixel, last);
    last = pixel;
  }
  EXPECT_GT(last, 640.0);
}

TEST(Projection, BoxContainsEverythingVisible) {
  std::mt19937_64 random(5);
  const SceneView view = view_north(200, 150, 180);
  const auto projection = make_projection(view, glm::dmat4{1.0});
  ASSERT_OK(projection);
  // World: x east, y north, z up. A triangle that begins behind the camera.
  const std::vector<glm::vec3> positions{{-40, -300, -20}, {30, 400, 60}, {90, 500, -100}};
  const std::vector<std::uint16_t> indices{0, 1, 2};
  const PixelBox box = box_of(*projection, positions, indices);
  ASSERT_FALSE(box.empty());
  for (int i = 0; i < 2000; ++i) {
    const double u = uniform(random, 0, 1), v = uniform(random, 0, 1 - u);
    const glm::dvec3 world =
        glm::dvec3(positions[0]) * (1 - u - v) + u * glm::dvec3(positions[1]) + v * glm::dvec3(positions[2]);
    const glm::dvec3 camera(projection->model_to_camera * glm::dvec4(world, 1.0));
    if (camera.z < view.near_m) continue;
    const glm::dvec2 pixel = glm::round(pixel_of(*projection, camera));
    if (pixel.x < 0 || pixel.y < 0 || pixel.x >= 200 || pixel.y >= 150) continue;
    EXPECT_TRUE(pixel.x >= box.left && pixel.x < box.right && pixel.y >= box.top && pixel.y < box.bottom)
        << pixel.x << ", " << pixel.y;
  }
  EXPECT_TRUE(box_of(*projection, std::vector<glm::vec3>{{0, -300, 0}, {1, -300, 0}, {0, -300, 1}}, indices).empty());
}

TEST(Placement, TurnsClockwiseSeenFromAbove) {
  const auto at = [](const Placement& p, glm::dvec3 model) {
    return glm::dvec3(model_to_world(p) * glm::dvec4(model, 1.0));
  };
  const auto expect_near = [](glm::dvec3 a, glm::dvec3 b) {
    EXPECT_NEAR(glm::length(a - b), 0.0, 1e-12) << a.x << " " << a.y << " " << a.z;
  };
  const Placement north{100, 200, 300, {}, 1.0};
  expect_near(at(north, {0, 0, 0}), {100, 200, 300});
  expect_near(at(north, {1, 0, 0}), {101, 200, 300});
  expect_near(at(north, {0, 1, 0}), {100, 200, 301});
  expect_near(at(north, {0, 0, -1}), {100, 201, 300});
  const Placement east{0, 0, 0, from_degrees(90), 2.0};
  expect_near(at(east, {0, 0, -1}), {2, 0, 0});
  expect_near(at(east, {1, 0, 0}), {0, -2, 0});
  Placement z_up = east;
  z_up.up_axis = UpAxis::z;
  expect_near(at(z_up, {0, 1, 0}), {2, 0, 0});
  expect_near(at(z_up, {0, 0, 1}), {0, 0, 2});
}

TEST(Letterbox, KeepsTheAspectRatioAndFillsOneDirection) {
  const auto in = [](int w, int h, int pw, int ph) { return letterbox({0, w, h, false}, pw, ph); };
  EXPECT_EQ(in(1920, 1080, 1920, 1080).width, 1920);
  EXPECT_EQ(in(1920, 1080, 640, 480).width, 1440);
  EXPECT_EQ(in(1920, 1080, 640, 480).x, 240);
  EXPECT_EQ(in(600, 1000, 640, 480).height, 450);
  EXPECT_EQ(in(600, 1000, 640, 480).y, 275);
  EXPECT_EQ(in(0, 100, 640, 480).width, 0);
  EXPECT_EQ(in(100, 100, 0, 480).width, 0);
}

TEST(PictureCutting, EveryPixelLiesInOneRectangleOfItsKind) {
  std::mt19937_64 random(11);
  for (int round = 0; round < 30; ++round) {
    const int width = 1 + static_cast<int>(random() % 300), height = 1 + static_cast<int>(random() % 200);
    PixelBox box;
    box.left = static_cast<int>(random() % static_cast<unsigned>(width));
    box.top = static_cast<int>(random() % static_cast<unsigned>(height));
    box.right = box.left + 1 + static_cast<int>(random() % static_cast<unsigned>(width - box.left));
    box.bottom = box.top + 1 + static_cast<int>(random() % static_cast<unsigned>(height - box.top));
    Image<float> coverage(box.right - box.left, box.bottom - box.top);
    const double cx = uniform(random, 0, coverage.width()), cy = uniform(random, 0, coverage.height());
    for (int y = 0; y < coverage.height(); ++y)
      for (int x = 0; x < coverage.width(); ++x)
        coverage.at(x, y) = static_cast<float>(std::clamp(40.0 - std::hypot(x - cx, y - cy), 0.0, 1.0));
    AirlightGrid grid;
    grid.first_px = {0.2 * width, 0.1 * height};
    grid.last_px = {0.9 * width, 0.7 * height};
    const CutRectangles rectangles = cut_at_lines(cut_picture(width, height, box, coverage), grid);
    Image<int> times(width, height);
    for (std::size_t area = 0; area < kCutAreas; ++area)
      for (const PixelBox& r : rectangles[area])
        for (int y = r.top; y < r.bottom; ++y)
          for (int x = r.left; x < r.right; ++x) {
            ++times.at(x, y);
            const bool inside = coverage.contains(x - box.left, y - box.top);
            const float there = inside ? coverage.at(x - box.left, y - box.top) : 0.0f;
            if (area == static_cast<std::size_t>(CutArea::plain)) {
              ASSERT_EQ(there, 0.0f);
            }
            if (area == static_cast<std::size_t>(CutArea::covered)) {
              ASSERT_EQ(there, 1.0f);
            }
          }
    for (const int count : times.elements()) ASSERT_EQ(count, 1);
  }
}

TEST(Airlight, IsBilinearBetweenPointsAndClampedBeyond) {
  AirlightGrid grid;
  grid.first_px = {10, 20};
  grid.last_px = {80, 40};
  // A plane: bilinear interpolation is exact.
  for (int row = 0; row < AirlightGrid::kRows; ++row)
    for (int column = 0; column < AirlightGrid::kColumns; ++column)
      grid.light[static_cast<std::size_t>(row * AirlightGrid::kColumns + column)] = {10.0 + 10 * column,
                                                                                     20.0 + 10 * row, 1.0};
  for (const glm::dvec2 pixel : {glm::dvec2{10, 20}, {33.3, 21.7}, {80, 40}, {79.999, 39}, {50, 30}}) {
    EXPECT_NEAR(airlight_at(grid, pixel).r, pixel.x, 1e-12);
    EXPECT_NEAR(airlight_at(grid, pixel).g, pixel.y, 1e-12);
  }
  EXPECT_NEAR(airlight_at(grid, {-500, 30}).r, 10, 1e-12);
  EXPECT_NEAR(airlight_at(grid, {500, 1000}).r, 80, 1e-12);
  EXPECT_NEAR(airlight_at(grid, {500, 1000}).g, 40, 1e-12);
  grid.last_px = grid.first_px;  // one value everywhere
  EXPECT_EQ(airlight_at(grid, {3, 4}), grid.light[0]);
}

}  // namespace
}  // namespace kasumi
