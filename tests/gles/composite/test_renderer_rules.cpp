// What a renderer guarantees besides the picture itself.
#include <cmath>

#include "tests/gles/scenes.hpp"
#include "tests/heap_in_use.hpp"

namespace kasumi {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class RendererRules : public GlesTest {
 protected:
  // A wall over the whole picture, one colour, no air: every pixel has the same exact value.
  ReferenceScene wall() {
    ReferenceScene scene = box_scene();
    scene.model = box_model(4000, 4000, 10, 1);
    scene.model_to_world = model_to_world({0, 3500, -2000, {}, 1.0});
    scene.appearance.aerial_perspective = false;
    scene.appearance.horizon.light.fill({1.0, 1.0, 1.0});
    return scene;
  }
};

TEST_F(RendererRules, SameInputsGiveSameBits) {
  const ReferenceScene scene = box_scene();
  const Image<Rgb8> camera = landscape(160, 120);
  std::vector<Image<Rgb8>> pictures;
  for (int i = 0; i < 2; ++i) {
    Renderer renderer = loaded(scene);
    pictures.push_back(draw(renderer, scene.measured, view_of(camera)));
    pictures.push_back(draw(renderer, scene.measured, view_of(camera)));
  }
  for (const auto& picture : pictures) EXPECT_EQ(picture.elements(), pictures.front().elements());
}

TEST_F(RendererRules, DitheringKeepsTheMean) {
  ReferenceScene scene = wall();
  scene.appearance.light.around = furnace(0.2).light.around;  // uniform light, which bytes represent exactly
  const Image<Rgb8> camera(160, 120);
  for (const auto kind : {ResponseCurve::Kind::srgb, ResponseCurve::Kind::linear}) {
    scene.response.kind = kind;
    Renderer renderer = loaded(scene);
    for (const double exposure : {0.03, 0.111, 0.4, 0.77}) {
      scene.measured.light.fill(glm::dvec3{exposure});
      const auto reference = render_reference(scene, camera, pixel_centre());
      const Image<Rgb8> picture = draw(renderer, scene.measured, view_of(camera));
      glm::dvec3 mean{0.0}, exact{0.0};
      for (int y = 0; y < 120; ++y)
        for (int x = 0; x < 160; ++x) {
          mean += glm::dvec3(picture.at(x, y)) / (160.0 * 120.0);
          exact += reference.encoded.at(x, y) / (160.0 * 120.0);
        }
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(mean[c], exact[c], 0.05) << "steps of 255, exposure " << exposure;
    }
  }
}

TEST_F(RendererRules, TheLayerIsValidForEveryExposure) {
  ReferenceScene scene = box_scene();
  for (const bool force_rgba8 : {false, true}) {
    Renderer renderer = loaded(scene, {.force_rgba8 = force_rgba8});
    for (const double exposure : {1.0 / 64.0, 0.2, 1.0, 3.0}) {
      scene.measured = measured_airlight(scene.view, exposure);
      Image<Rgb8> camera = landscape(160, 120);
      for (Rgb8& pixel : camera.elements())
        pixel = Rgb8(glm::min(glm::dvec3(pixel) * std::pow(exposure, 1 / 2.4), glm::dvec3(255.0)));
      expect_like(draw(renderer, scene.measured, view_of(camera)), render_reference(scene, camera, turned_lattice()));
    }
  }
}

TEST_F(RendererRules, OnePassMatchesTheLayerInsideTheObject) {
  ReferenceScene scene = box_scene();
  scene.measured.saturation = 1.4;
  const Image<Rgb8> camera = landscape(160, 120);
  const auto reference = render_reference(scene, camera, upright_grid(4));
  Renderer renderer = loaded(scene);
  const Image<Rgb8> cached = draw(renderer, scene.measured, view_of(camera));
  for (const int samples : {1, 4})
    for (const auto detail : {HazeDetail::per_vertex, HazeDetail::per_fragment}) {
      const Image<Rgb8> moving = draw_moving(renderer, scene, view_of(camera), detail, samples);
      int inside = 0;
      double edges = 0.0, edge_pixels = 0.0;
      for (int y = 1; y < 119; ++y)
        for (int x = 1; x < 159; ++x) {
          // Edges within the object, between two walls, are edges too: only neighbourhoods within one wall are
          // compared.
          bool flat = true;
          for (int dy = -1; dy <= 1; ++dy)
            for (int dx = -1; dx <= 1; ++dx) {
              const glm::dvec4 there = reference.layer.at(x + dx, y + dy), here = reference.layer.at(x, y);
              flat = flat && there.a == 1.0 && std::abs(there.r - here.r) < 0.02;
            }
          for (int c = 0; c < 3; ++c) {
            const int difference = std::abs(int(moving.at(x, y)[c]) - int(cached.at(x, y)[c]));
            if (flat) inside = std::max(inside, difference);
            if (!flat && reference.layer.at(x, y).a > 0.0) edges += difference, edge_pixels += 1.0;
          }
        }
      EXPECT_LE(inside, 2) << "steps of 255 inside a wall";
      EXPECT_LE(edges / edge_pixels, samples == 1 ? 14.0 : 8.0) << "steps of 255 on edges, on average";
    }
}

TEST_F(RendererRules, MultisamplingSmoothsTheMovingView) {
  const ReferenceScene scene = box_scene();
  const Image<Rgb8> camera = landscape(160, 120);
  if (make_target(160, 120, 4).samples() < 4) GTEST_SKIP() << info().renderer << " does not multisample";
  const auto reference = render_reference(scene, camera, turned_lattice());
  Renderer renderer = loaded(scene);
  const double plain = psnr(draw_moving(renderer, scene, view_of(camera), HazeDetail::per_vertex, 1), reference);
  const double smooth = psnr(draw_moving(renderer, scene, view_of(camera), HazeDetail::per_vertex, 4), reference);
  EXPECT_GE(smooth, plain + 3.0) << "dB";
}

TEST_F(RendererRules, WithoutAVisibleObjectTheCamerasPictureIsUnchanged) {
  const Image<Rgb8> camera = landscape(160, 120);
  for (const Placement& away :
       {Placement{0, -3500, 0, {}, 1.0}, Placement{0, 20, 0, {}, 1.0}, Placement{2000, 3500, 0, {}, 1.0}}) {
    ReferenceScene scene = box_scene();
    scene.model = box_model(10, 10, 10);
    scene.model_to_world = model_to_world(away);
    Renderer renderer = loaded(scene);
    EXPECT_TRUE(renderer.object_box().empty());
    EXPECT_EQ(draw(renderer, scene.measured, view_of(camera)).elements(), camera.elements());
    EXPECT_EQ(draw_moving(renderer, scene, view_of(camera), HazeDetail::per_vertex).elements(), camera.elements());
  }
}

TEST_F(RendererRules, WhollyHiddenObjectsLeaveNoTrace) {
  ReferenceScene scene = box_scene();
  scene.mask = Image<std::uint8_t>(160, 120, 0);
  const Image<Rgb8> camera = landscape(160, 120);
  Renderer renderer = loaded(scene);
  EXPECT_EQ(draw(renderer, scene.measured, view_of(camera)).elements(), camera.elements());
  EXPECT_EQ(draw_moving(renderer, scene, view_of(camera), HazeDetail::per_vertex).elements(), camera.elements());
}

TEST_F(RendererRules, APoseChangeInvalidatesTheLayer) {
  const ReferenceScene scene = box_scene();
  const Image<Rgb8> camera = landscape(160, 120);
  Renderer renderer = loaded(scene);
  EXPECT_NE(draw(renderer, scene.measured, view_of(camera)).elements(), camera.elements());
  ASSERT_OK(renderer.set_view(scene.view, model_to_world({20, 3600, -12, {}, 1.0})));
  EXPECT_EQ(draw(renderer, scene.measured, view_of(camera)).elements(), camera.elements());
}

TEST_F(RendererRules, RedrawsTheLayerOnlyOnRequest) {
  // The layer is redrawn on request only: another sun changes nothing until then.
  ReferenceScene scene = box_scene();
  const Image<Rgb8> camera = landscape(160, 120);
  Renderer renderer = loaded(scene);
  const Image<Rgb8> afternoon_picture = draw(renderer, scene.measured, view_of(camera));
  scene.appearance.light.sun_irradiance = glm::dvec3{0.0};
  EXPECT_EQ(draw(renderer, scene.measured, view_of(camera)).elements(), afternoon_picture.elements());
  ASSERT_OK(renderer.redraw_layer(scene.appearance));
  EXPECT_NE(draw(renderer, scene.measured, view_of(camera)).elements(), afternoon_picture.elements());
}

TEST_F(RendererRules, TheOldLayerIsShownUntilTheNewOneIsWhole) {
  ReferenceScene scene = box_scene();
  const Image<Rgb8> camera = landscape(160, 120);
  Renderer renderer = loaded(scene);
  const auto picture = [&] { return draw(renderer, scene.measured, view_of(camera)).elements(); };
  const auto before = picture();
  scene.appearance.light.sun_direction = glm::normalize(glm::dvec3{0.5, -0.4, 0.6});
  ASSERT_OK(renderer.begin_layer(scene.appearance));
  int pieces = 0;
  for (auto whole = renderer.continue_layer(); whole && !*whole; whole = renderer.continue_layer()) {
    ASSERT_LT(++pieces, 1000);
    EXPECT_EQ(picture(), before) << "after piece " << pieces;
  }
  EXPECT_GT(pieces, 16) << "the shadow's maps, at least";
  const auto after = picture();
  EXPECT_NE(after, before);
  Renderer at_once = loaded(scene);
  EXPECT_EQ(draw(at_once, scene.measured, view_of(camera)).elements(), after);
}

TEST_F(RendererRules, ASmallLayerIsDrawnIntoSmallBuffers) {
  if (!kHeapTells || !info().software) GTEST_SKIP() << "the driver's memory is not this process's";
  const ReferenceScene scene = wall();
  Renderer renderer = make_renderer();
  ASSERT_OK(renderer.set_detail({.point_spread_px = 0.5}));
  load(renderer, scene);
  draw(renderer, scene.measured, view_of(landscape(160, 120)));
  const double before = heap_in_use();
  ASSERT_OK(renderer.begin_layer(scene.appearance));
  ASSERT_OK(renderer.continue_layer([] { return false; }));
  const double taken = heap_in_use() - before;
  EXPECT_GT(taken, 1e6) << "samples, their depth, and what is spread of them";
  EXPECT_LT(taken, 8e6) << "the largest tile's would take 21 MB";
}

TEST_F(RendererRules, DrawsALayerLargerThanOneTile) {
  // Seams between tiles of the supersampling would show as edges in a plain wall.
  ReferenceScene scene = wall();
  scene.view = view_north(500, 450, 6000);
  scene.measured = measured_airlight(scene.view);
  Renderer renderer = loaded(scene);
  const auto layer = renderer.read_layer();
  ASSERT_OK(layer);
  ASSERT_EQ(layer->width(), 500);
  ASSERT_EQ(layer->height(), 450);
  const glm::vec4 first = layer->elements().front();
  for (const glm::vec4& texel : layer->elements())
    for (int c = 0; c < 3; ++c)
      ASSERT_NEAR(texel[c], first[c], 0.002f * first[c]);  // the layer is dithered by a step of a half
  for (const glm::vec4& texel : layer->elements()) ASSERT_EQ(texel.a, 1.0f);
}

TEST_F(RendererRules, ReducesTexturesTheDriverCannotTake) {
  ReferenceScene scene = box_scene();
  ModelTexture wide;
  wide.pixels = Image<glm::u8vec4>(info().max_texture_size * 2, 4, glm::u8vec4{200, 100, 50, 255});
  scene.model.textures.push_back(wide);
  scene.model.materials[0].texture = 0;
  Renderer renderer = loaded(scene);
  ASSERT_EQ(renderer.notes().size(), 1u);
  EXPECT_THAT(renderer.notes()[0], HasSubstr("reduced to"));
}

// The memory of a larger one, taken in one go, holds the picture up (row 36 of docs/faults.md).
TEST_F(RendererRules, WithoutAGpuATextureHas2048TexelsASideAtMost) {
  if (!info().software) GTEST_SKIP() << info().renderer << " is a GPU";
  ReferenceScene scene = box_scene();
  ModelTexture large;
  large.pixels = Image<glm::u8vec4>(4096, 2048, glm::u8vec4{200, 100, 50, 255});
  scene.model.textures.push_back(large);
  scene.model.materials[0].texture = 0;
  Renderer renderer = loaded(scene);
  EXPECT_THAT(renderer.notes(), ElementsAre(HasSubstr("texture of 4096 x 2048 reduced to 2048 x 1024")));
}

TEST_F(RendererRules, ReportsEveryProblemWithItsInput) {
  Renderer renderer = make_renderer();
  const Image<Rgb8> camera = landscape(160, 120);
  ReferenceScene scene = box_scene();

  EXPECT_THAT(renderer.redraw_layer(scene.appearance).error().message,
              testing::AllOf(HasSubstr("no model"), HasSubstr("no view")));
  Model empty;
  empty.name = "nothing.glb";
  EXPECT_THAT(renderer.set_model(empty).error().message, HasSubstr("nothing.glb: no triangles"));
  Model wild = scene.model;
  wild.parts[0].indices[5] = 4000000;
  EXPECT_THAT(renderer.set_model(wild).error().message, HasSubstr("index 4000000"));
  SceneView view = scene.view;
  view.focal_px.x = -1.0;
  view.near_m = 0.0;
  EXPECT_THAT(renderer.set_view(view, scene.model_to_world).error().message,
              testing::AllOf(HasSubstr("focal length -1"), HasSubstr("near 0 m")));
  view = scene.view;
  view.distortion = {-40.0, 0, 0, 0, 0};
  view.focal_px = {400, 400};
  EXPECT_THAT(renderer.set_view(view, scene.model_to_world).error().message, HasSubstr("folds the picture"));
  EXPECT_THAT(renderer.set_view(scene.view, glm::dmat4{0.0}).error().message, HasSubstr("model_to_world"));
  ResponseCurve curve{ResponseCurve::Kind::table, {{{0.0, 0.5, 0.5, 1.0}, {0.0}, {0.0, 1.0}}}};
  EXPECT_THAT(renderer.set_response(curve).error().message,
              testing::AllOf(HasSubstr("entry 2 = 0.5"), HasSubstr("channel 1: 1 entries")));

  load(renderer, scene);
  Offscreen target = make_target(160, 120);
  const Image<Rgb8> small(80, 60);
  EXPECT_THAT(renderer.upload(view_of(small)).error().message, HasSubstr("80 x 60 pixels: the view is of 160 x 120"));
  ASSERT_OK(renderer.upload(view_of(camera)));
  AirlightGrid dark = scene.measured;
  dark.light[3].g = std::nan("");
  EXPECT_THAT(renderer.draw(dark, target.target()).error().message, HasSubstr("light[3] channel 1"));
  AirlightGrid wild_colours = scene.measured;
  wild_colours.saturation = 0.0;
  EXPECT_THAT(renderer.draw(wild_colours, target.target()).error().message,
              HasSubstr("measured airlight: saturation 0: expected a finite number > 0"));
  scene.appearance.horizon.light[0].b = 0.0;
  scene.appearance.light.sun_direction = {0, 0, 2};
  EXPECT_THAT(renderer.redraw_layer(scene.appearance).error().message,
              testing::AllOf(HasSubstr("expected a finite number > 0"), HasSubstr("unit vector")));
  ASSERT_OK(renderer.set_foreground(Image<std::uint8_t>(10, 10, 255)));
  EXPECT_THAT(renderer.redraw_layer(box_scene().appearance).error().message, HasSubstr("10 x 10"));
}

}  // namespace
}  // namespace kasumi
