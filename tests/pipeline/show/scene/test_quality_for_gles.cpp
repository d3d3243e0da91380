// From the scene camera's quality to the renderer's settings.
#include <cmath>

#include <gtest/gtest.h>

#include "pipeline/show/scene/for_gles.hpp"
#include "pipeline/show/scene/scene_air.hpp"

namespace kasumi {
namespace {

TEST(QualityForGles, ChromaIsSharedAsInTheLayout) {
  const auto pixels = [](PixelLayout layout, bool shared = true) {
    const auto detail = detail_for_gles({.point_spread_px = 0.5, .shared_chroma = shared}, layout);
    EXPECT_EQ(detail.point_spread_px, 0.5);
    return std::pair(detail.chroma_columns, detail.chroma_rows);
  };
  for (const auto layout : {PixelLayout::nv12, PixelLayout::i420}) EXPECT_EQ(pixels(layout), std::pair(2, 2));
  for (const auto layout : {PixelLayout::yuyv, PixelLayout::uyvy, PixelLayout::i422})
    EXPECT_EQ(pixels(layout), std::pair(2, 1));
  for (const auto layout : {PixelLayout::rgb8, PixelLayout::bgra8, PixelLayout::i444, PixelLayout::grey8})
    EXPECT_EQ(pixels(layout), std::pair(1, 1));
  EXPECT_EQ(pixels(PixelLayout::nv12, false), std::pair(1, 1));
}

TEST(QualityForGles, SharpeningAndBlocksReachTheRenderer) {
  const auto detail = detail_for_gles({.sharpening = 0.7, .jpeg_blocks = true}, PixelLayout::i420);
  EXPECT_EQ(detail.sharpening, 0.7);
  EXPECT_TRUE(detail.jpeg_blocks);
  EXPECT_EQ(detail_for_gles({}, PixelLayout::i420), ObjectDetail{});
}

TEST(QualityForGles, HazeAddsToTheCamerasOwnBlurInQuartersOfAPixel) {
  const auto spread = [](double own_px, double haze_px) {
    return detail_for_gles({.point_spread_px = own_px}, PixelLayout::rgb8, haze_px).point_spread_px;
  };
  EXPECT_EQ(spread(0.6, 0.0), 0.6) << "none: as measured";
  EXPECT_EQ(spread(0.0, 1.3), 1.25);
  EXPECT_EQ(spread(0.6, 0.8), 1.0) << "variances add";
  EXPECT_EQ(spread(0.6, 0.05), 0.6) << "never sharper than the camera";
  EXPECT_EQ(spread(2.5, 3.0), kWidestPointSpread_px);
}

TEST(QualityForGles, HazeBlursByTheRootOfItsOpticalDepth) {
  Installation installation;
  installation.site.altitude_m = 300.0;
  installation.object.placement = {.east_m = 2100.0, .north_m = 2800.0, .up_m = 0.0};
  installation.surroundings.haze_blur_px = 1.5;
  const SceneAir air(installation, {});
  const auto under = [](double turbidity) {
    SkyReport report;
    report.air.emplace().air = Turbidity{turbidity};
    return report;
  };
  const auto measure = spectral_measure(installation.scene);
  const auto path = optical_path(300.0, 300.0, 3500.0);
  for (const double turbidity : {2.0, 4.0, 9.0}) {
    const double left = attenuation_reference(measure, ScatteringModel::morales2017, Turbidity{turbidity}, path).g;
    EXPECT_NEAR(air.conditions(under(turbidity)).haze_blur_px, 1.5 * std::sqrt(-std::log(left)), 0.005);
  }
  EXPECT_EQ(SceneAir({}, {}).conditions(under(9.0)).haze_blur_px, 0.0) << "off by default";
}

TEST(QualityForGles, NoiseFollowsTheElectronCount) {
  // 8000 electrons at gain 1; at gain 4 full scale is 2000, and a channel amplified by 1.5 reaches it with 1333 of
  // them.
  const ImageQuality quality{.full_scale_electrons = 8000.0, .read_electrons = 5.0};
  const auto noise = noise_for_gles(quality, {1.5, 1.0, 1.0}, 4.0, 77);
  const double light = 0.3;
  const auto variance = [&](int c) { return noise.shot[c] * light + noise.read[c] * noise.read[c]; };
  const double green = 0.3 * 2000.0;  // electrons, whose variance equals their number
  EXPECT_NEAR(variance(1), (green + 25.0) / (2000.0 * 2000.0), 1e-12);
  const double full = 2000.0 / 1.5, red = 0.3 * full;
  EXPECT_NEAR(variance(0), (red + 25.0) / (full * full), 1e-12);
  EXPECT_EQ(noise.pattern, 77u);
  EXPECT_TRUE(noise_for_gles({}, glm::dvec3{1.0}, 4.0, 77).none());
}

TEST(QualityForGles, DepthIsTheDistanceAlongTheAxis) {
  Camera scene;
  scene.lens = pinhole_lens({{100.0, 100.0}, {2.0, 1.0}, {}});
  Image<float> distances(5, 3, 1000.0f);
  distances.at(4, 0) = 0.0f;
  const auto depths = depth_for_gles(scene, distances);
  EXPECT_NEAR(depths.at(2, 1), 1000.0, 1e-3);
  EXPECT_NEAR(depths.at(0, 2), 1000.0 / std::sqrt(1.0 + 0.02 * 0.02 + 0.01 * 0.01), 1e-3);
  EXPECT_EQ(depths.at(4, 0), 0.0f);
  EXPECT_TRUE(depth_for_gles(scene, {}).empty());
}

}  // namespace
}  // namespace kasumi
