// The object is as blurred as the camera's picture: point spread and chroma subsampling, against closed forms.
#include <cmath>

#include "gles/object/coarse_spread.hpp"
#include "gles/object/pixel_means.hpp"
#include "gles/object/point_spread.hpp"
#include "tests/gles/scenes.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

// Integral of the normal cumulative distribution.
double twice_integrated(double t, double sigma) {
  return t * 0.5 * std::erfc(-t / (sigma * std::sqrt(2.0))) +
         sigma / std::sqrt(2.0 * kPi) * std::exp(-0.5 * t * t / (sigma * sigma));
}
// Coverage of the pixel at x by a half plane to the right of `edge`, blurred by sigma.
double share_of_plane(double x, double edge, double sigma) {
  return twice_integrated(x + 0.5 - edge, sigma) - twice_integrated(x - 0.5 - edge, sigma);
}

// Samples locate a vertical or horizontal edge to 1/34 of a pixel; the coverage error is that times the edge's slope.
double tolerance(double sigma) {
  return std::erf(0.5 / (sigma * std::sqrt(2.0))) / 34.0 + 0.003;
}

class Detail : public GlesTest {
 protected:
  static constexpr double kFocal_px = 6000.0, kDistance_m = 3500.0, kMetresPerPixel = kDistance_m / kFocal_px;

  // A white, infinitely thin board facing the camera, between the given columns and rows.
  ReferenceScene board(double left_px, double right_px, double top_px = -200.0, double bottom_px = 400.0) const {
    ReferenceScene scene;
    scene.view = view_north(160, 120, kFocal_px);
    const auto east = [&](double px) { return (px - scene.view.centre_px.x) * kMetresPerPixel; };
    const auto up = [&](double px) { return (scene.view.centre_px.y - px) * kMetresPerPixel; };
    scene.model.name = "board";
    scene.model.materials.push_back({.name = "white", .base_colour = {1.0f, 1.0f, 1.0f, 1.0f}});
    scene.model.parts.push_back(
        box_part({east(left_px), up(bottom_px), -0.005}, {east(right_px), up(top_px), 0.005}, 1));
    scene.model_to_world = model_to_world({0, kDistance_m, 0, {}, 1.0});
    scene.appearance = furnace(1.0);
    scene.measured = measured_airlight(scene.view);
    return scene;
  }

  // Premultiplied N and coverage of the whole picture.
  Image<glm::dvec4> layer_of(const ReferenceScene& scene, const ObjectDetail& detail,
                             const RendererOptions& options = {}) {
    Renderer renderer = make_renderer(options);
    EXPECT_TRUE(renderer.set_detail(detail));
    load(renderer, scene);
    const auto layer = renderer.read_layer().value();
    const PixelBox box = renderer.object_box();
    Image<glm::dvec4> whole(scene.view.width, scene.view.height);
    for (int y = box.top; y < box.bottom; ++y)
      for (int x = box.left; x < box.right; ++x) whole.at(x, y) = glm::dvec4(layer.at(x - box.left, y - box.top));
    return whole;
  }
  static glm::dvec4 sum_of(const Image<glm::dvec4>& layer) {
    glm::dvec4 sum{0.0};
    for (const auto& texel : layer.elements()) sum += texel;
    return sum;
  }
};

TEST_F(Detail, WeightsHaveTheGaussiansVarianceHoweverNarrow) {
  for (const double sigma : {0.2, 0.5, 1.0, 2.06, 5.0, 12.4}) {
    const auto weights = gaussian_weights(sigma);
    double sum = weights[0], variance = 0.0;
    for (std::size_t i = 1; i < weights.size(); ++i) {
      sum += 2.0 * weights[i];
      variance += 2.0 * weights[i] * double(i * i);
      EXPECT_LT(weights[i], weights[i - 1]);
    }
    EXPECT_NEAR(sum, 1.0, 1e-12);
    EXPECT_NEAR(variance, sigma * sigma, 0.012 * sigma * sigma) << "the kernel covers 3.5 deviations";
  }
}

// Along the rows, then by columns into the means: the same weights as the mean of samples spread along both.
TEST_F(Detail, APixelsMeanHoldsTheSpreadAlongTheColumns) {
  for (const double sigma : {0.5, 2.06, 4.1}) {
    const auto spread = gaussian_weights(sigma);
    const int radius = static_cast<int>(spread.size()) - 1;
    const auto weight = [&](int apart) {
      return std::abs(apart) <= radius ? spread[std::size_t(std::abs(apart))] : 0.0;
    };
    const auto by_rows = mean_weights(spread);
    ASSERT_EQ(by_rows.size(), std::size_t(2 * radius + 5));
    const auto in_column = [&](int column, int row) {
      const int place = row + radius + 2, mirrored = 2 * radius + 4 - place;
      return by_rows[std::size_t(column >= 0 ? place : mirrored)][std::abs(column)];
    };
    for (int b = -radius - 2; b <= radius + 2; ++b)
      for (int a = -radius - 2; a <= radius + 2; ++a) {
        double both = 0.0, means = 0.0;
        for (const auto& offset : kLatticeOffsets) both += weight(a - offset[0]) * weight(b - offset[1]) / 17.0;
        for (int column = -2; column <= 2; ++column) means += weight(a - column) * in_column(column, b);
        ASSERT_NEAR(means, both, 1e-15) << sigma << ": " << a << ", " << b;
      }
  }
}

// Of straight edges through all places around a pixel's middle, that lies anywhere between two samples that are kept.
TEST_F(Detail, ACoarserLatticeHoldsAWideSpread) {
  EXPECT_EQ(split_spread(2.4).step, 1) << "narrow: every sample counts";
  for (const double sigma : {2.48, 3.0, 4.12, 6.2, 12.4}) {
    const SplitSpread split = split_spread(sigma);
    ASSERT_GT(split.step, 1);
    EXPECT_NEAR(std::hypot(split.first, split.second), sigma, 1e-9);
    const auto first = gaussian_weights(split.first), whole = gaussian_weights(sigma);
    const auto weight = [](const std::vector<double>& weights, int apart) {
      const auto at = std::size_t(std::abs(apart));
      return at < weights.size() ? weights[at] : 0.0;
    };
    const CoarseWeights coarse = coarse_weights(split);
    const int reach = int(whole.size() + first.size()) + coarse.reach_samples(split.step);
    // Of the samples by their distance from the middle.
    std::vector<std::vector<double>> by_way(std::size_t(split.step), std::vector<double>(std::size_t(2 * reach + 1)));
    for (int phase = 0; phase < split.step; ++phase)
      for (int away = -reach; away <= reach; ++away)
        for (std::size_t i = 0; i < coarse.weights.size(); ++i)
          by_way[std::size_t(phase)][std::size_t(away + reach)] +=
              coarse.weights[i][phase] * weight(first, away - ((int(i) - coarse.before) * split.step - phase));
    double worst = 0.0;
    for (int phase = 0; phase < split.step * split.step; ++phase) {
      const auto &across = by_way[std::size_t(phase % split.step)], &down = by_way[std::size_t(phase / split.step)];
      for (const double turned : {0.0, 0.4, 0.8, 1.2, 1.6, 2.0, 2.4, 2.8}) {
        std::vector<double> misses(std::size_t(4 * reach), 0.0);  // by the distance from the edge
        for (int b = -reach; b <= reach; ++b)
          for (int a = -reach; a <= reach; ++a) {
            double exact = 0.0;
            for (const auto& offset : kLatticeOffsets)
              exact += weight(whole, a - offset[0]) * weight(whole, b - offset[1]) / 17.0;
            misses[std::size_t(std::lround(a * std::cos(turned) + b * std::sin(turned)) + 2 * reach)] +=
                across[std::size_t(a + reach)] * down[std::size_t(b + reach)] - exact;
          }
        double sum = 0.0;
        for (const double miss : misses) worst = std::max(worst, std::abs(sum += miss));
      }
    }
    EXPECT_LT(worst, sigma < 3.0 ? 0.0015 : 0.0008) << "of the edge's height; sigma " << sigma;
  }
}

TEST_F(Detail, AnEdgeIsBlurredAsTheClosedFormSaysAtAnySubpixelPosition) {
  const auto expect_edge = [&](double sigma, double edge, const RendererOptions& options) {
    const auto layer = layer_of(board(edge, 400.0), {.point_spread_px = sigma}, options);
    double worst = 0.0;
    for (int x = 0; x < 160; ++x) worst = std::max(worst, std::abs(layer.at(x, 60).a - share_of_plane(x, edge, sigma)));
    EXPECT_LE(worst, tolerance(sigma)) << "of the coverage; sigma " << sigma << ", edge at " << edge;
  };
  for (const double sigma : {0.3, 0.5, 0.7, 1.0, 2.5})
    for (const double edge : {70.5, 70.8, 71.07}) expect_edge(sigma, edge, {});
  expect_edge(0.5, 70.63, {.force_rgba8 = true});
}

TEST_F(Detail, AHorizontalEdgeIsBlurredTheSame) {
  const auto layer = layer_of(board(-200.0, 400.0, 40.3, 400.0), {.point_spread_px = 0.7});
  for (int y = 0; y < 120; ++y)
    EXPECT_NEAR(layer.at(80, y).a, share_of_plane(y, 40.3, 0.7), tolerance(0.7)) << "row " << y;
}

TEST_F(Detail, AColumnThinnerThanAPixelIsBlurredWithoutLoss) {
  constexpr double kSigma = 0.5;
  for (const double left : {80.0, 80.21, 80.44, 80.69}) {
    const double width = 6.0 / 17.0;  // the same number of samples at any position
    const auto scene = board(left, left + width);
    const auto sharp = layer_of(scene, {}), spread = layer_of(scene, {.point_spread_px = kSigma});
    double sharp_sum = 0.0, spread_sum = 0.0;
    for (int x = 0; x < 160; ++x) {
      const double expected = share_of_plane(x, left, kSigma) - share_of_plane(x, left + width, kSigma);
      EXPECT_NEAR(spread.at(x, 60).a, expected, 0.012) << "column " << x << " of one that begins at " << left;
      sharp_sum += sharp.at(x, 60).a;
      spread_sum += spread.at(x, 60).a;
    }
    EXPECT_NEAR(spread_sum, width, 0.01) << "pixels covered by a row";
    EXPECT_NEAR(spread_sum, sharp_sum, 0.003) << "pixels covered by a row";
  }
}

TEST_F(Detail, BlurringPreservesTheLight) {
  ReferenceScene scene = board(0, 0);
  scene.model = columns_model(7, 0.3, 4.0, 20.0);
  scene.appearance = afternoon(scene.view);
  const auto sharp = sum_of(layer_of(scene, {}));
  for (const double sigma : {0.4, 1.3}) {
    const auto spread = sum_of(layer_of(scene, {.point_spread_px = sigma}));
    for (int c = 0; c < 4; ++c) EXPECT_NEAR(spread[c], sharp[c], 0.003 * sharp[c]) << "channel " << c;
  }
}

TEST_F(Detail, MatchesASupersampledPictureBlurredOnTheCpu) {
  // 16 rays a pixel, blurred by the Gaussian at their own distances, then averaged into pixels.
  constexpr int kSide = 4;
  constexpr double kSigma = 0.8;
  const ReferenceScene scene = box_scene();
  const int w = scene.view.width, h = scene.view.height;
  Image<glm::dvec4> fine(kSide * w, kSide * h);
  const auto offsets = upright_grid(kSide);
  for (int j = 0; j < kSide; ++j)
    for (int i = 0; i < kSide; ++i) {
      const auto rays = render_reference(scene, Image<Rgb8>(w, h), {offsets[std::size_t(kSide * j + i)]});
      for (int y = 0; y < h; ++y)
        for (int x = 0; x < w; ++x) fine.at(kSide * x + i, kSide * y + j) = rays.layer.at(x, y);
    }
  const auto spread_at = [&](double centre, int count, auto at) {
    glm::dvec4 sum{0.0};
    for (int i = 0; i < count; ++i) {
      const double away = (i + 0.5) / kSide - 0.5 - centre;
      if (std::abs(away) > 4.0) continue;
      const double part =
          share_of_plane(0.0, away - 0.5 / kSide, kSigma) - share_of_plane(0.0, away + 0.5 / kSide, kSigma);
      sum += part * at(i);
    }
    return sum;
  };
  Image<glm::dvec4> across(w, kSide * h), expected(w, h);
  for (int y = 0; y < kSide * h; ++y)
    for (int x = 0; x < w; ++x) across.at(x, y) = spread_at(x, kSide * w, [&](int i) { return fine.at(i, y); });
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) expected.at(x, y) = spread_at(y, kSide * h, [&](int j) { return across.at(x, j); });

  const auto layer = layer_of(scene, {.point_spread_px = kSigma});
  double worst = 0.0, square = 0.0;
  for (int y = 6; y < h - 6; ++y)
    for (int x = 6; x < w - 6; ++x)
      for (int c = 0; c < 4; ++c) {
        const double miss = std::abs(layer.at(x, y)[c] - expected.at(x, y)[c]);
        worst = std::max(worst, miss);
        square += miss * miss / (4.0 * w * h);
      }
  // The rays, too, locate an edge no better than to 1/8 pixel.
  EXPECT_LE(worst, 0.08) << "of N and coverage";
  EXPECT_LE(std::sqrt(square), 0.006) << "of N and coverage";
}

TEST_F(Detail, TheMasksEdgeIsNotBlurred) {
  ReferenceScene scene = board(-200.0, 400.0);
  scene.mask = Image<std::uint8_t>(160, 120, 255);
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 160; ++x) scene.mask.at(x, y) = x < 70 ? 0 : x == 70 ? 100 : 255;
  const auto layer = layer_of(scene, {.point_spread_px = 1.5});
  for (int x = 0; x < 160; ++x) EXPECT_NEAR(layer.at(x, 60).a, scene.mask.at(x, 60) / 255.0, 0.001) << "column " << x;
}

TEST_F(Detail, WhatLiesOutsideThePictureContributes) {
  for (const auto& [left, right] : {std::pair{-30.0, 20.0}, {-200.0, 400.0}}) {
    // In many parts, some of which lie entirely outside.
    ReferenceScene scene = board(left, right);
    const ModelPart whole = scene.model.parts[0];
    scene.model.parts.clear();
    const glm::dvec3 low(whole.vertices[0].position.x, -60, -0.005);
    const double width = (right - left) * kMetresPerPixel;
    for (int i = 0; i < 60; ++i)
      scene.model.parts.push_back(
          box_part({low.x + width * i / 60, -60, -0.005}, {low.x + width * (i + 1) / 60, 60, 0.005}, 1));
    const auto layer = layer_of(scene, {.point_spread_px = 2.0});
    for (int x = 0; x < 8; ++x) EXPECT_NEAR(layer.at(x, 60).a, 1.0, 0.002) << "column " << x;
    EXPECT_NEAR(layer.at(3, 0).a, 1.0, 0.002);
  }
}

TEST_F(Detail, ABoardJustOutsideThePictureBlursIntoIt) {
  const auto layer = layer_of(board(-40.0, -1.0), {.point_spread_px = 1.0});
  for (int x = 0; x < 4; ++x)
    EXPECT_NEAR(layer.at(x, 60).a, 1.0 - share_of_plane(x, -1.0, 1.0), 0.012) << "column " << x;
}

TEST_F(Detail, HasNoSeamsWhenLargerThanOneTile) {
  ReferenceScene scene = board(-900.0, 900.0, -900.0, 900.0);
  scene.view = view_north(260, 230, kFocal_px);
  scene.measured = measured_airlight(scene.view);
  const auto layer = layer_of(scene, {.point_spread_px = 1.5, .chroma_columns = 2, .chroma_rows = 2});
  for (const auto& texel : layer.elements()) {
    ASSERT_EQ(texel.a, 1.0);
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(texel[c], layer.at(0, 0)[c], 0.002 * layer.at(0, 0)[c]);
  }
}

TEST_F(Detail, WhatLiesFarApartIsDrawnAsEachAlone) {
  const auto boards = [&](bool left, bool right) {
    ReferenceScene scene = board(0.0, 0.0);
    scene.view = view_north(560, 260, kFocal_px);
    scene.measured = measured_airlight(scene.view);
    scene.model.materials.push_back({.name = "grey", .base_colour = {0.2f, 0.3f, 0.5f, 1.0f}});
    scene.model.parts.clear();
    const auto add = [&](double from_px, double to_px, double top_px, double bottom_px, int material) {
      const glm::dvec2 centre = scene.view.centre_px;
      scene.model.parts.push_back(
          box_part({(from_px - centre.x) * kMetresPerPixel, (centre.y - bottom_px) * kMetresPerPixel, -0.005},
                   {(to_px - centre.x) * kMetresPerPixel, (centre.y - top_px) * kMetresPerPixel, 0.005}, 1));
      scene.model.parts.back().material = material;
    };
    if (left) add(20.3, 47.8, 13.2, 71.9, 0);
    if (right) add(431.6, 520.1, 180.4, 243.7, 1);
    return layer_of(scene, {.point_spread_px = 1.5, .chroma_columns = 2, .chroma_rows = 2});
  };
  const auto both = boards(true, true), left = boards(true, false), right = boards(false, true);
  EXPECT_EQ(both.at(280, 130), glm::dvec4{0.0});
  const double area = (47.8 - 20.3) * (71.9 - 13.2) + (520.1 - 431.6) * (243.7 - 180.4);
  EXPECT_NEAR(sum_of(both).a, area, 0.002 * area) << "pixels covered";
  for (int y = 0; y < 260; ++y)
    for (int x = 0; x < 560; ++x)
      for (int c = 0; c < 4; ++c)
        ASSERT_NEAR(both.at(x, y)[c], left.at(x, y)[c] + right.at(x, y)[c], 0.001) << x << ", " << y;
}

// Stripes of two colours, each as wide as a pixel, on a board that covers a part of the picture.
class SharedChroma : public Detail {
 protected:
  ReferenceScene stripes() const {
    ReferenceScene scene = board(20.5, 120.5, 10.5, 100.5);
    scene.model.textures.push_back({.pixels = Image<glm::u8vec4>(4, 4)});
    for (int y = 0; y < 4; ++y)
      for (int x = 0; x < 4; ++x)
        scene.model.textures[0].pixels.at(x, y) =
            (x + y) % 2 == 0 ? glm::u8vec4{230, 60, 40, 255} : glm::u8vec4{40, 200, 90, 255};
    scene.model.materials[0].texture = 0;
    for (ModelVertex& vertex : scene.model.parts[0].vertices) vertex.texture *= glm::vec2{33.3f, 21.7f};
    return scene;
  }
  static double grey(const glm::dvec4& n) { return 0.299 * n.r + 0.587 * n.g + 0.114 * n.b; }
};

TEST_F(SharedChroma, EveryBlockSharesItsChromaAndEveryPixelKeepsItsLuma) {
  const auto scene = stripes();
  const auto own = layer_of(scene, {});
  for (const glm::ivec2 block : {glm::ivec2{2, 1}, glm::ivec2{2, 2}}) {
    const auto shared = layer_of(scene, {.chroma_columns = block.x, .chroma_rows = block.y});
    for (int y = 20; y < 90; y += block.y)
      for (int x = 30; x < 110; x += 2) {
        glm::dvec3 mean{0.0};
        for (int j = 0; j < block.y; ++j)
          for (int i = 0; i < 2; ++i)
            mean += (glm::dvec3(own.at(x + i, y + j)) - grey(own.at(x + i, y + j))) / (2.0 * block.y);
        for (int j = 0; j < block.y; ++j)
          for (int i = 0; i < 2; ++i) {
            const auto pixel = shared.at(x + i, y + j);
            ASSERT_NEAR(grey(pixel), grey(own.at(x + i, y + j)), 0.002) << x + i << ", " << y + j;
            for (int c = 0; c < 3; ++c) ASSERT_NEAR(pixel[c] - grey(pixel), mean[c], 0.003) << x + i << ", " << y + j;
          }
      }
  }
}

TEST_F(SharedChroma, LeavesCoverageAndLightUnchanged) {
  const auto scene = stripes();
  const auto own = layer_of(scene, {}), shared = layer_of(scene, {.chroma_columns = 2, .chroma_rows = 2});
  for (std::size_t i = 0; i < own.elements().size(); ++i) ASSERT_EQ(own.elements()[i].a, shared.elements()[i].a);
  const auto before = sum_of(own), after = sum_of(shared);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(after[c], before[c], 0.001 * before[c]);
}

TEST_F(SharedChroma, LeavesPixelsWithoutTheObjectUnchanged) {
  const auto scene = stripes();
  const Image<Rgb8> camera = landscape(160, 120);
  Renderer renderer = make_renderer();
  ASSERT_OK(renderer.set_detail({.chroma_columns = 2, .chroma_rows = 2}));
  load(renderer, scene);
  const auto picture = draw(renderer, scene.measured, view_of(camera));
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 160; ++x)
      if (x < 20 || x > 121 || y < 10 || y > 101) {
        ASSERT_EQ(picture.at(x, y), camera.at(x, y)) << x << ", " << y;
      }
}

TEST_F(Detail, ImpossibleValuesAreRefused) {
  Renderer renderer = make_renderer();
  EXPECT_THAT(renderer.set_detail({.point_spread_px = 3.5, .chroma_columns = 3}).error().message,
              testing::AllOf(HasSubstr("point spread of 3.5 px"), HasSubstr("3 x 1 pixels")));
  EXPECT_FALSE(renderer.set_detail({.point_spread_px = std::nan("")}));
}

TEST_F(Detail, ChangedSettingsInvalidateTheLayer) {
  const auto scene = board(70.5, 90.5);
  const Image<Rgb8> camera = landscape(160, 120);
  Renderer renderer = loaded(scene);
  const PixelBox before = renderer.object_box();
  ASSERT_OK(renderer.set_detail({.point_spread_px = 1.0}));
  EXPECT_LT(renderer.object_box().left, before.left);
  EXPECT_EQ(draw(renderer, scene.measured, view_of(camera)).elements(), camera.elements());
}

}  // namespace
}  // namespace kasumi
