// How real surfaces hide the object: against rays on the CPU and against known geometry.
#include <cmath>

#include "tests/gles/scenes.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

class SceneDepths : public GlesTest {
 protected:
  void SetUp() override {
    GlesTest::SetUp();
    if (context_ && make_renderer_notes_too_few_units())
      GTEST_SKIP() << info().renderer << " has too few texture units";
  }
  bool make_renderer_notes_too_few_units() {
    Renderer renderer = make_renderer();
    return renderer.set_scene_depth(Image<float>(4, 4, 1.0f)) && !renderer.notes().empty() &&
           renderer.notes().back().starts_with("the depth map");
  }

  // A board over the whole picture, 3500 m away.
  ReferenceScene board() const {
    ReferenceScene scene;
    scene.view = view_north(160, 120, 6000);
    scene.model = box_model(400, 400, 0.01, 1);
    scene.model_to_world = model_to_world({0, 3500, -200, {}, 1.0});
    scene.appearance = furnace(1.0);
    scene.measured = measured_airlight(scene.view);
    scene.depth_m = Image<float>(160, 120);
    return scene;
  }
  Image<glm::vec4> layer_of(const ReferenceScene& scene, const RendererOptions& options = {}) {
    Renderer renderer = loaded(scene, options);
    const PixelBox box = renderer.object_box();
    EXPECT_EQ(box, (PixelBox{0, 0, 160, 120}));
    return renderer.read_layer().value();
  }
};

TEST_F(SceneDepths, HideWhatLiesBehindAndNothingElse) {
  ReferenceScene scene = board();
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 160; ++x)
      scene.depth_m.at(x, y) = x < 40 ? 0.0f : x < 80 ? 3000.0f : x < 120 ? 3499.5f : 3500.5f;
  for (const bool force_rgba8 : {false, true}) {
    const auto layer = layer_of(scene, {.force_rgba8 = force_rgba8});
    for (int y = 0; y < 120; ++y)
      for (int x = 0; x < 160; ++x) ASSERT_EQ(layer.at(x, y).a, x < 40 || x >= 120 ? 1.0f : 0.0f) << x << ", " << y;
  }
}

TEST_F(SceneDepths, MatchTheRayTracer) {
  // Hills before the box and behind it, a tree of a few pixels, sky.
  ReferenceScene scene = box_scene();
  scene.depth_m = Image<float>(160, 120);
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 160; ++x) {
      const double hill = 62.0 + 9.0 * std::sin(0.11 * x) + 3.0 * std::sin(0.71 * x);
      if (y > hill) scene.depth_m.at(x, y) = static_cast<float>(3560.0 - 3.5 * (y - hill));
      if (std::hypot(x - 95.0, y - 50.0) < 6.3) scene.depth_m.at(x, y) = 900.0f;
    }
  const Image<Rgb8> camera = landscape(160, 120);
  const auto reference = render_reference(scene, camera, turned_lattice());
  ReferenceScene without = scene;
  without.depth_m = {};
  for (const bool force_rgba8 : {false, true}) {
    Renderer renderer = loaded(scene, {.force_rgba8 = force_rgba8});
    const auto picture = draw(renderer, scene.measured, view_of(camera));
    expect_like(picture, reference, 48.0);
    EXPECT_LT(psnr(picture, render_reference(without, camera, turned_lattice())), 35.0) << "something must be hidden";
  }
}

TEST_F(SceneDepths, GiveASlantedEdgeWithoutSteps) {
  // The true edge of a near surface runs through pixels; the map only has what covers their centres.
  ReferenceScene scene = board();
  const glm::dvec2 normal = glm::normalize(glm::dvec2{1.0, 0.37});
  const auto side = [&](double x, double y) { return glm::dot(normal, glm::dvec2{x - 80.2, y - 60.0}); };
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 160; ++x) scene.depth_m.at(x, y) = side(x, y) < 0.0 ? 500.0f : 0.0f;
  const auto layer = layer_of(scene);
  double worst = 0.0, square = 0.0, hard_square = 0.0, mean = 0.0;
  int count = 0;
  for (int y = 1; y < 119; ++y)
    for (int x = 1; x < 159; ++x) {
      double open = 0.0;
      for (const auto& at : upright_grid(16)) open += side(x + at.x, y + at.y) >= 0.0 ? 1.0 / 256.0 : 0.0;
      const double miss = double(layer.at(x, y).a) - open;
      if (std::abs(side(x, y)) > 1.5) {
        ASSERT_NEAR(miss, 0.0, 1e-3) << x << ", " << y;
        continue;
      }
      worst = std::max(worst, std::abs(miss));
      square += miss * miss;
      hard_square += std::pow((side(x, y) >= 0.0 ? 1.0 : 0.0) - open, 2.0);
      mean += miss;
      ++count;
    }
  EXPECT_LE(worst, 0.4) << "of a pixel's coverage; all or nothing misses by half";
  EXPECT_LE(std::sqrt(square / count), 0.75 * std::sqrt(hard_square / count)) << "compared with all or nothing";
  EXPECT_NEAR(mean / count, 0.0, 0.02) << "the edge must not shift";
}

TEST_F(SceneDepths, LetTheObjectStandInSlopingGround) {
  // Ground that gets nearer downwards by 2 m a row: it meets the board at row 60.3, a fifth of a row lower with each
  // column.
  ReferenceScene scene = board();
  const auto meets = [](double x) { return 60.3 + 0.2 * (x - 80.0); };
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 160; ++x) scene.depth_m.at(x, y) = static_cast<float>(3499.995 - 2.0 * (y - meets(x)));
  const auto layer = layer_of(scene);
  for (int x = 10; x < 150; ++x) {
    double seen = 0.0;
    for (int y = 0; y < 120; ++y) seen += double(layer.at(x, y).a);
    // Rows of the picture above the line, through the pixel's middle.
    EXPECT_NEAR(seen, meets(x) + 0.5, 0.51) << "rows seen of column " << x;
  }
}

TEST_F(SceneDepths, AnEmptyMapHidesNothingAndOneOfAnotherSizeIsRefused) {
  ReferenceScene scene = board();
  scene.depth_m = {};
  const auto whole = layer_of(scene);
  for (const auto& texel : whole.elements()) ASSERT_EQ(texel.a, 1.0f);
  Renderer renderer = loaded(scene);
  ASSERT_OK(renderer.set_scene_depth(Image<float>(80, 60, 100.0f)));
  EXPECT_THAT(renderer.redraw_layer(scene.appearance).error().message,
              HasSubstr("depth map of 80 x 60 pixels: the view is of 160 x 120"));
  ASSERT_OK(renderer.set_scene_depth({}));
  EXPECT_TRUE(renderer.redraw_layer(scene.appearance));
}

TEST_F(SceneDepths, ASoftMaskLeavesNeitherDarkNorBrightFringes) {
  // Object and background have the same light: whatever the mask, nothing of it may be visible.
  ReferenceScene scene = board();
  scene.depth_m = {};
  scene.mask = Image<std::uint8_t>(160, 120);
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 160; ++x) scene.mask.at(x, y) = static_cast<std::uint8_t>(std::clamp((x - 40) * 4, 0, 255));
  for (const double level : {0.05, 0.3, 0.7}) {
    const double code = reference_code(scene.response, 0, level);
    const auto grey = static_cast<std::uint8_t>(std::lround(255.0 * code));
    scene.model.materials[0].base_colour = {1.0f, 1.0f, 1.0f, 1.0f};
    scene.measured.light.fill(glm::dvec3{reference_light(scene.response, 0, grey / 255.0)});
    for (const double spread_px : {0.0, 1.2}) {
      Renderer renderer = make_renderer();
      ASSERT_OK(renderer.set_detail({.point_spread_px = spread_px}));
      load(renderer, scene);
      const Image<Rgb8> camera(160, 120, Rgb8{grey, grey, grey});
      const auto picture = draw(renderer, scene.measured, view_of(camera));
      for (int y = 0; y < 120; ++y)
        for (int x = 0; x < 160; ++x)
          for (int c = 0; c < 3; ++c)
            ASSERT_NEAR(int(picture.at(x, y)[c]), int(grey), 1) << x << ", " << y << ": steps of 255";
    }
  }
}

}  // namespace
}  // namespace kasumi
