#include <opencv2/calib3d.hpp>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "base/geometry.hpp"
#include "tests/calib/lens/lenses.hpp"

namespace kasumi {
namespace {

glm::dvec3 ray_at(double off_axis_deg, double turn_deg) {
  const double a = from_degrees(off_axis_deg).value, t = from_degrees(turn_deg).value;
  return {std::sin(a) * std::cos(t), std::sin(a) * std::sin(t), std::cos(a)};
}

TEST(Lens, ProjectingAPixelsRayGivesThatPixelOverTheWholeImage) {
  for (const auto& [what, lens, width, height] : sample_lenses()) {
    int seen = 0;
    double worst_px = 0.0, worst_length = 0.0;
    for (double y = -0.5; y <= height - 0.5; y += 3.7)
      for (double x = -0.5; x <= width - 0.5; x += 3.7) {
        const auto ray = lens->unproject({x, y});
        if (!ray) continue;
        ++seen;
        const auto back = lens->project(*ray);
        ASSERT_TRUE(back) << what << " at " << x << ", " << y;
        worst_px = std::max(worst_px, glm::distance(*back, {x, y}));
        worst_length = std::max(worst_length, std::abs(glm::length(*ray) - 1.0));
      }
    EXPECT_GT(seen, 0.7 * (width / 3.7) * (height / 3.7)) << what;
    EXPECT_LE(worst_px, 1e-6) << what;
    EXPECT_LE(worst_length, 1e-12) << what;
  }
}

TEST(Lens, UnprojectingARaysPixelGivesThatRay) {
  for (const auto& [what, lens, width, height] : sample_lenses()) {
    const double widest_deg = what.starts_with("pinhole") ? 25.0 : 90.0;
    for (double off = 0.0; off <= widest_deg; off += 2.5)
      for (double turn = 0.0; turn < 360.0; turn += 15.0) {
        const auto pixel = lens->project(7.0 * ray_at(off, turn));
        ASSERT_TRUE(pixel) << what << " at " << off;
        const auto ray = lens->unproject(*pixel);
        ASSERT_TRUE(ray) << what << " at " << off;
        EXPECT_LE(angle_between(*ray, ray_at(off, turn)).value, 1e-10) << what << " at " << off << ", " << turn;
      }
  }
}

TEST(Lens, TheAxisIsAtTheCentreAndXGrowsRightYDown) {
  for (const auto& [what, lens, width, height] : sample_lenses()) {
    const auto centre = lens->project({0.0, 0.0, 2.0}).value();
    EXPECT_GT(lens->project({0.1, 0.0, 1.0})->x, centre.x + 5.0) << what;
    EXPECT_GT(lens->project({0.0, 0.1, 1.0})->y, centre.y + 5.0) << what;
  }
}

TEST(Lens, AnEquidistantRadiusIsFocalLengthTimesAngle) {
  const auto lens = equidistant_lens({100.0, 50.0}, 60.0, from_degrees(100.0));
  const auto pixel = lens->project({0.0, 3.0, 0.0}).value();
  EXPECT_NEAR(pixel.x, 100.0, 1e-12);
  EXPECT_NEAR(pixel.y, 50.0 + 60.0 * kPi / 2.0, 1e-12);
}

TEST(Lens, EqualSolidAnglesHaveEqualAreasInAnEquisolidImage) {
  const double focal = 60.0;
  const auto lens = equisolid_lens({0.0, 0.0}, focal, from_degrees(180.0));
  for (const double off : {20.0, 60.0, 90.0, 150.0}) {
    const double radius = glm::length(lens->project(ray_at(off, 33.0)).value());
    const double solid_angle = 2.0 * kPi * (1.0 - std::cos(from_degrees(off).value));
    EXPECT_NEAR(kPi * radius * radius, focal * focal * solid_angle, 1e-8);
  }
}

std::vector<cv::Point3d> rays_within(double widest_deg) {
  std::vector<cv::Point3d> rays;
  for (double off = 0.0; off <= widest_deg; off += 4.3)
    for (double turn = 0.0; turn < 360.0; turn += 24.0) {
      const auto ray = 3.0 * ray_at(off, turn);
      rays.emplace_back(ray.x, ray.y, ray.z);
    }
  return rays;
}

TEST(Lens, TheFisheyeModelAgreesWithOpenCV) {
  const auto lens = opencv_fisheye_lens({336.8, 337.9}, {543.4, 377.7}, kSampleFisheye, from_degrees(89.0));
  const cv::Matx33d camera(336.8, 0.0, 543.4, 0.0, 337.9, 377.7, 0.0, 0.0, 1.0);
  const auto rays = rays_within(86.0);
  std::vector<cv::Point2d> theirs;
  cv::fisheye::projectPoints(rays, theirs, cv::Vec3d(), cv::Vec3d(), camera,
                             cv::Vec4d(kSampleFisheye[0], kSampleFisheye[1], kSampleFisheye[2], kSampleFisheye[3]));
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const auto ours = lens->project({rays[i].x, rays[i].y, rays[i].z}).value();
    EXPECT_NEAR(ours.x, theirs[i].x, 1e-8);
    EXPECT_NEAR(ours.y, theirs[i].y, 1e-8);
  }
}

TEST(Lens, ThePinholeModelAgreesWithOpenCV) {
  const auto model = sample_pinhole();
  const auto lens = pinhole_lens(model);
  const cv::Matx33d camera(model.focal_px.x, 0.0, model.centre.x, 0.0, model.focal_px.y, model.centre.y, 0.0, 0.0, 1.0);
  const auto rays = rays_within(36.0);
  std::vector<cv::Point2d> theirs;
  cv::projectPoints(rays, cv::Vec3d(), cv::Vec3d(), camera,
                    std::vector<double>(model.distortion.begin(), model.distortion.end()), theirs);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const auto ours = lens->project({rays[i].x, rays[i].y, rays[i].z}).value();
    EXPECT_NEAR(ours.x, theirs[i].x, 1e-8);
    EXPECT_NEAR(ours.y, theirs[i].y, 1e-8);
  }
}

TEST(Lens, OnlyAPinholeHasAPinholeModel) {
  EXPECT_EQ(pinhole_model(*pinhole_lens(sample_pinhole()))->distortion, sample_pinhole().distortion);
  EXPECT_FALSE(pinhole_model(*equidistant_lens({}, 100.0, from_degrees(90.0))));
}

}  // namespace
}  // namespace kasumi
