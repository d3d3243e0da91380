// The sun's shadow of the object, on itself and on its ground: against rays, closed forms and invariants.
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "gles/shadow/sun_shadow.hpp"
#include "tests/gles/object/reference_shading.hpp"
#include "tests/gles/scenes.hpp"
#include "tests/heap_in_use.hpp"

namespace kasumi {
namespace {

constexpr float kGroundColour = 0.2f;

// A level square of 2 half_m by 2 half_m around the model's origin, in squares small enough for air paths to be linear
// across them.
ModelPart level_part(double half_m, double up_m, int material) {
  constexpr std::ptrdiff_t kCells = 8, kFace = 6 * kCells * kCells;
  ModelPart part = box_part({-half_m, up_m - 1.0, -half_m}, {half_m, up_m, half_m}, kCells, material);
  part.indices = {part.indices.begin() + 4 * kFace, part.indices.begin() + 5 * kFace};  // the face that looks up
  return part;
}

glm::dvec3 sun_at(double elevation_deg, double azimuth_deg) {
  const double up = from_degrees(elevation_deg).value, around = from_degrees(azimuth_deg).value;
  return {std::cos(up) * std::sin(around), std::cos(up) * std::cos(around), std::sin(up)};
}

// A camera on the z axis at height_m over a place north_m away, looking down at it.
SceneView view_down(int width, int height, double focal_px, double north_m, double height_m) {
  SceneView view = view_north(width, height, focal_px);
  const double pitch = std::atan2(-height_m, north_m), c = std::cos(pitch), s = std::sin(pitch);
  view.world_to_camera = glm::dmat4({1, 0, 0, 0}, {0, s, c, 0}, {0, -c, s, 0}, {0, 0, 0, 1});
  view.near_m = 0.2 * std::hypot(north_m, height_m);
  return view;
}

// A gate on level ground, seen from above at 700 m: posts, a roof over them, a wall that stands apart.
ReferenceScene gate_scene() {
  ReferenceScene scene;
  scene.view = view_down(128, 96, 1000, 600, 350);
  scene.model.materials = {{.name = "plaster", .base_colour = {0.7f, 0.6f, 0.45f, 1.0f}},
                           {.name = "ground", .base_colour = {kGroundColour, kGroundColour, kGroundColour, 1.0f}}};
  for (const double x : {-15.0, 0.0, 15.0}) scene.model.parts.push_back(box_part({x - 1, 0, -1}, {x + 1, 20, 1}, 1));
  scene.model.parts.push_back(box_part({-20, 20, -6}, {20, 22, 6}, 1));
  scene.model.parts.push_back(box_part({-8, 0, 14}, {8, 6, 16}, 1));
  scene.model.ground = {level_part(120, 0, 1)};
  scene.model_to_world = model_to_world({0, 600, -350, from_degrees(25), 1.0});
  scene.appearance = afternoon(scene.view);
  scene.appearance.shadows = true;
  scene.measured = measured_airlight(scene.view);
  return scene;
}

// How the camera shows ground of that colour under the scene's light, encoded.
Image<Rgb8> ground_picture(const ReferenceScene& scene) {
  ReferenceScene alone = scene;
  alone.model.parts = {level_part(4000, 0, 1)};
  alone.model.ground.clear();
  alone.appearance.shadows = false;
  const Image<Rgb8> nothing(scene.view.width, scene.view.height);
  const auto reference = render_reference(alone, nothing, pixel_centre());
  Image<Rgb8> picture(scene.view.width, scene.view.height);
  for (std::size_t i = 0; i < picture.elements().size(); ++i)
    picture.elements()[i] = Rgb8(glm::round(reference.encoded.elements()[i]));
  return picture;
}

class Shadow : public GlesTest {
 protected:
  void expect_same(const ReferenceScene& scene, const RendererOptions& options = {}, double least_db = 45.0) {
    expect_same_with(scene, {options}, least_db);
  }
  // The rays are cast only once because they take most of the time.
  void expect_same_with(const ReferenceScene& scene, const std::vector<RendererOptions>& ways, double least_db = 45.0) {
    const Image<Rgb8> camera = ground_picture(scene);
    const auto reference = render_reference(scene, camera, turned_lattice());
    for (const RendererOptions& options : ways) {
      Renderer renderer = loaded(scene, options);
      const Image<Rgb8> picture = draw(renderer, scene.measured, view_of(camera));
      fmt::print("{:.2f} dB\n", psnr(picture, reference));
      expect_like(picture, reference, least_db);
    }
  }

  Image<glm::vec4> layer_of(const ReferenceScene& scene, const RendererOptions& options = {}) {
    Renderer renderer = loaded(scene, options);
    auto layer = renderer.read_layer();
    EXPECT_TRUE(layer) << layer.error().message;
    return std::move(*layer);
  }
};

TEST_F(Shadow, MatchesRaysTracedToTheSunsDisc) {
  ReferenceScene scene = gate_scene();
  for (const auto& [elevation, azimuth] : {std::pair{12.0, 250.0}, std::pair{40.0, 130.0}, std::pair{88.0, 180.0}}) {
    SCOPED_TRACE(elevation);
    scene.appearance.light.sun_direction = sun_at(elevation, azimuth);
    expect_same(scene);
  }
}

TEST_F(Shadow, IsTheSameWithoutOptionalDriverFeatures) {
  const ReferenceScene scene = gate_scene();
  expect_same_with(scene, {{.force_rgba8 = true}, {.force_packed_shadows = true}, {.force_smooth_shadows = true}});
}

TEST_F(Shadow, PackedDepthEqualsTheDriversDepth) {
  const ReferenceScene scene = gate_scene();
  const auto depth = layer_of(scene), packed = layer_of(scene, {.force_packed_shadows = true});
  int others = 0;
  for (std::size_t i = 0; i < depth.elements().size(); ++i)
    for (int c = 0; c < 4; ++c) others += std::abs(depth.elements()[i][c] - packed.elements()[i][c]) > 0.002f ? 1 : 0;
  EXPECT_LE(others, 4) << "values that differ by more than .002: depths within a float's last bit of a surface";
}

TEST_F(Shadow, OfMaskedMaterialHasItsHoles) {
  ReferenceScene scene = gate_scene();
  ModelTexture texture = soft_texture(32);
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 32; ++x)
      texture.pixels.at(x, y).a = static_cast<std::uint8_t>(
          std::clamp(127.0 + 900.0 * std::sin(2 * kPi * x / 32.0) * std::cos(2 * kPi * y / 32.0), 0.0, 255.0));
  scene.model.textures.push_back(texture);
  scene.model.materials.push_back({.name = "lattice",
                                   .texture = 0,
                                   .alpha = ModelMaterial::Alpha::mask,
                                   .alpha_cutoff = 0.45f,
                                   .double_sided = true});
  scene.model.parts[3].material = 2;
  expect_same(scene);
}

TEST_F(Shadow, IsNotCastByGlass) {
  ReferenceScene scene = gate_scene();
  scene.model.materials[0].alpha = ModelMaterial::Alpha::blend;
  scene.model.materials[0].base_colour.a = 0.5f;
  const auto with = layer_of(scene);
  scene.appearance.shadows = false;
  EXPECT_EQ(with.elements(), layer_of(scene).elements());
}

TEST_F(Shadow, RemovesOnlyTheSunsShareOfTheGroundsLight) {
  // In the core of a shadow: camera * k + (1 - k) (1 - Gamma) Linf, k = sky / (sky + sun), for ground of the proxy's
  // colour in every channel, for any other ground in green.
  ReferenceScene scene = gate_scene();
  scene.appearance.light.sun_direction = sun_at(50, 180);
  const auto reference = render_reference(scene, Image<Rgb8>(128, 96), turned_lattice());
  const ObjectLight& light = scene.appearance.light;
  const glm::dvec3 sun = light.sun_irradiance * light.sun_direction.z;
  const glm::dvec3 sun_share = sun / (sun + reference_sky_irradiance(reference_sky(light), {0, 0, 1}));
  for (const bool proxy_colour : {true, false}) {
    Image<Rgb8> camera = ground_picture(scene);
    if (!proxy_colour)
      for (Rgb8& pixel : camera.elements()) pixel = Rgb8(0.8 * glm::dvec3(pixel) + glm::dvec3{10, 20, 0});
    const auto expected = before_picture(reference, scene, camera);
    Renderer renderer = loaded(scene);
    const auto picture = draw(renderer, scene.measured, view_of(camera));
    int core = 0;
    glm::dvec3 mean{0.0};
    for (int y = 0; y < 96; ++y)
      for (int x = 0; x < 128; ++x) {
        bool inside = x > 1 && y > 1 && x < 126 && y < 94;  // at least two pixels inside the core of a shadow
        for (int dy = -2; inside && dy <= 2; ++dy)
          for (int dx = -2; dx <= 2; ++dx)
            inside = inside && glm::length(reference.taken.at(x + dx, y + dy) - sun_share) < 1e-9;
        if (!inside) continue;
        ++core;
        const glm::dvec3 miss = glm::dvec3(picture.at(x, y)) - expected.encoded.at(x, y);
        mean += miss;
        EXPECT_NEAR(miss.g, 0.0, 4.0) << "steps of 255";
        EXPECT_LE(std::max(std::abs(miss.r), std::abs(miss.b)), proxy_colour ? 4.0 : 10.0) << "steps of 255";
      }
    mean /= core;
    fmt::print("mean miss in the shadow R {:.2f} G {:.2f} B {:.2f}\n", mean.r, mean.g, mean.b);
    EXPECT_NEAR(mean.g, 0.0, 0.3) << "steps of 255, on average";
    EXPECT_LE(std::max(std::abs(mean.r), std::abs(mean.b)), proxy_colour ? 0.5 : 8.0) << "steps of 255, on average";
    EXPECT_GT(core, 40);
  }
}

TEST_F(Shadow, LeavesUncoveredPixelsUnchangedBitForBit) {
  const ReferenceScene scene = gate_scene();
  const Image<Rgb8> camera = landscape(128, 96);
  const auto reference = render_reference(scene, camera, upright_grid(4));
  Renderer renderer = loaded(scene);
  const Image<Rgb8> picture = draw(renderer, scene.measured, view_of(camera));
  int free = 0, shaded = 0;
  for (int y = 1; y < 95; ++y)
    for (int x = 1; x < 127; ++x) {
      double near = 0.0;  // nor in the pixels around: the maps' texels are as large as a pixel
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) near = std::max(near, reference.taken.at(x + dx, y + dy).r);
      shaded += reference.taken.at(x, y).r > 0.5 ? 1 : 0;
      if (near > 0.0) continue;
      ++free;
      EXPECT_EQ(picture.at(x, y), camera.at(x, y));
    }
  EXPECT_GT(free, 5000);
  EXPECT_GT(shaded, 500);
}

TEST_F(Shadow, IsAbsentUnderAnOvercastSkyBitForBit) {
  ReferenceScene scene = gate_scene();
  scene.appearance.light.sun_irradiance = glm::dvec3{0.0};
  const Image<Rgb8> camera = landscape(128, 96);
  std::vector<Image<Rgb8>> cached, moving;
  for (const bool shadows : {true, false}) {
    scene.appearance.shadows = shadows;
    Renderer renderer = loaded(scene);
    cached.push_back(draw(renderer, scene.measured, view_of(camera)));
    moving.push_back(draw_moving(renderer, scene, view_of(camera), HazeDetail::per_vertex));
  }
  EXPECT_EQ(cached[0].elements(), cached[1].elements());
  EXPECT_EQ(moving[0].elements(), moving[1].elements());
}

// llvmpipe keeps what has been in flight until it draws as much at once again.
TEST_F(Shadow, LeavesNoMapsInMemoryOnceTheLayerIsDrawn) {
  if (!kHeapTells || !info().software) GTEST_SKIP() << "the driver's memory is not this process's";
  ReferenceScene scene = gate_scene();
  scene.view = view_down(480, 360, 1000, 600, 350);
  scene.appearance = afternoon(scene.view);
  scene.appearance.shadows = true;
  scene.measured = measured_airlight(scene.view);
  Renderer renderer = loaded(scene);
  const Image<Rgb8> camera = landscape(scene.view.width, scene.view.height);
  draw(renderer, scene.measured, view_of(camera));
  const double before = heap_in_use();
  scene.view.focal_px *= 12.0;  // the programs are the same, the maps are larger
  ASSERT_OK(renderer.set_view(scene.view, scene.model_to_world));
  ASSERT_OK(renderer.redraw_layer(scene.appearance));
  draw(renderer, scene.measured, view_of(camera));
  constexpr double kMaps = 16 * 2 * 1024.0 * 1024.0;
  EXPECT_LT(heap_in_use() - before, kMaps / 2.0) << "the larger layer included";
}

TEST_F(Shadow, IsAlsoDrawnInAMovingView) {
  ReferenceScene scene = gate_scene();
  const Image<Rgb8> camera = ground_picture(scene);
  const auto reference = render_reference(scene, camera, pixel_centre());
  for (const bool redrawn_before : {true, false}) {
    Renderer renderer = make_renderer();
    ASSERT_OK(renderer.set_model(scene.model));
    ASSERT_OK(renderer.set_view(scene.view, scene.model_to_world));
    if (redrawn_before) ASSERT_OK(renderer.redraw_layer(scene.appearance));
    for (const auto detail : {HazeDetail::per_vertex, HazeDetail::per_fragment}) {
      const Image<Rgb8> picture = draw_moving(renderer, scene, view_of(camera), detail);
      fmt::print("{:.2f} dB\n", psnr(picture, reference));
      expect_like(picture, reference, 40.0);
    }
  }
  // Neither object nor shadow appears over the foreground.
  scene.mask = Image<std::uint8_t>(128, 96, 0);
  Renderer renderer = loaded(scene);
  EXPECT_EQ(draw_moving(renderer, scene, view_of(camera), HazeDetail::per_vertex).elements(), camera.elements());
}

TEST_F(Shadow, OfAConvexObjectNeverFallsOnItself) {
  // A level slab, slabs leaning either way, and a ball, under suns from grazing to overhead: wherever the sun shines at
  // all, the light with shadows equals the light without.
  ReferenceScene scene = box_scene();
  scene.view = view_down(160, 120, 2500, 600, 250);
  scene.appearance = afternoon(scene.view);
  scene.appearance.aerial_perspective = false;
  scene.model_to_world = model_to_world({0, 600, -250, from_degrees(30), 1.0});
  for (const int shape : {0, 1, 2, 3}) {
    scene.model.parts = {shape == 3 ? ball_part({0, 0, 0}, 14, 96) : box_part({-15, -1, -15}, {15, 1, 15}, 3)};
    if (shape == 1 || shape == 2)
      for (ModelVertex& v : scene.model.parts[0].vertices) {
        const float lean = shape == 1 ? 0.5f : -0.5f, c = std::cos(lean), s = std::sin(lean);
        v.position = {v.position.x, c * v.position.y - s * v.position.z, s * v.position.y + c * v.position.z};
        v.normal = {v.normal.x, c * v.normal.y - s * v.normal.z, s * v.normal.y + c * v.normal.z};
      }
    for (const bool smooth : {false, true}) {
      if (smooth && (shape == 0 || shape == 2)) continue;
      Renderer renderer = make_renderer({.force_smooth_shadows = smooth});
      ASSERT_OK(renderer.set_model(scene.model));
      ASSERT_OK(renderer.set_view(scene.view, scene.model_to_world));
      for (const double elevation : {2.0, 5.0, 10.0, 20.0, 35.0, 50.0, 70.0, 85.0, 90.0})
        for (const double azimuth : {shape % 2 == 0 ? 215.0 : 10.0 + elevation}) {
          scene.appearance.light.sun_direction = sun_at(elevation, azimuth);
          std::array<Image<glm::vec4>, 2> layers;
          for (const bool shadows : {false, true}) {
            scene.appearance.shadows = shadows;
            ASSERT_OK(renderer.redraw_layer(scene.appearance));
            layers[shadows ? 1 : 0] = renderer.read_layer().value();
          }
          float worst = 0.0f;
          for (std::size_t i = 0; i < layers[0].elements().size(); ++i)
            for (int c = 0; c < 3; ++c)
              worst = std::max(worst, layers[0].elements()[i][c] - layers[1].elements()[i][c]);
          EXPECT_LE(worst, 0.002f) << "shape " << shape << ", sun at " << elevation << " deg, azimuth " << azimuth
                                   << (smooth ? ", by normals" : "");
        }
    }
  }
}

// Standard deviation of the position of a shadow's edge, over columns `left` .. `right` of row `row`.
double edge_deviation(const Image<glm::vec4>& layer, int row, int left, int right) {
  double weight = 0.0, first = 0.0, second = 0.0;
  for (int x = left; x < right; ++x) {
    const double step = double(layer.at(x + 1, row).a) - double(layer.at(x, row).a), at = x + 0.5;
    weight += step;
    first += step * at;
    second += step * at * at;
  }
  first /= weight;
  return std::sqrt(second / weight - first * first);
}

TEST_F(Shadow, SoftensWithDistanceAsTheSunsDiscDemands) {
  // The edge of a board that lies in the sun's vertical plane: its shadow fades over 2 d tan(.2665 deg), d being the
  // distance to it. The penumbra of a disc has a standard deviation of a quarter of that width.
  for (const double up_m : {25.0, 50.0, 100.0}) {
    ReferenceScene scene;
    scene.model.materials = {{.name = "board"}, {.name = "ground"}};
    scene.model.parts = {box_part({0, up_m, -6}, {12, up_m + 0.1, 6}, 1)};
    scene.model.ground = {level_part(150, 0, 1)};
    // From straight above, the board out of the picture: with the sun in the south its shadow lies to the north.
    const double elevation = 40.0, north_m = up_m / std::tan(from_degrees(elevation).value);
    constexpr double kPixel_m = 0.02, kHeight_m = 600.0;
    scene.view = view_north(160, 40, kHeight_m / kPixel_m);
    scene.view.world_to_camera = glm::dmat4({1, 0, 0, 0}, {0, -1, 0, 0}, {0, 0, -1, 0}, {0, 0, 0, 1});
    scene.model_to_world = model_to_world({0, -north_m, -kHeight_m, {}, 1.0});
    scene.appearance = afternoon(scene.view);
    scene.appearance.light.sun_direction = sun_at(elevation, 180);
    scene.appearance.shadows = true;
    Renderer renderer = loaded(scene);
    const auto layer = renderer.read_layer();
    ASSERT_OK(layer);
    const PixelBox box = renderer.object_box();
    ASSERT_FALSE(box.empty());
    const double width_m = 4.0 * kPixel_m * edge_deviation(*layer, layer->height() / 2, 0, layer->width() - 1);
    const double distance_m = (up_m + 0.05) / std::sin(from_degrees(elevation).value);
    const double expected_m = 2.0 * distance_m * std::tan(from_degrees(0.2665).value);
    fmt::print("{:.0f} m: penumbra {:.3f} m, closed form {:.3f} m\n", distance_m, width_m, expected_m);
    EXPECT_NEAR(width_m / expected_m, 1.0, 0.03);
  }
}

TEST_F(Shadow, OfThinPostsDoesNotFlickerWhileTheSunMoves) {
  // Posts half a pixel thick at 3 km: between redraws the whole shadow hardly changes, and no pixel changes more than
  // the ray tracer predicts.
  ReferenceScene scene = box_scene();
  scene.model = columns_model(14, 0.3, 5.0, 30.0);
  scene.model.materials.push_back({.name = "ground"});
  scene.model.ground = {level_part(150, 0, 1)};
  scene.view = view_down(200, 60, 5000, 3000, 400);
  scene.appearance = afternoon(scene.view);
  scene.appearance.shadows = true;
  scene.model_to_world = model_to_world({0, 3000, -400, {}, 1.0});
  std::optional<Image<glm::vec4>> last;
  double last_sum = 0.0;
  for (int step = 0; step < 6; ++step) {
    scene.appearance.light.sun_direction = sun_at(35.0 + 0.03 * step, 200.0 + 0.1 * step);
    const auto layer = layer_of(scene);
    double sum = 0.0;
    for (const glm::vec4& texel : layer.elements()) sum += texel.a < 0.999f ? double(texel.a) : 0.0;
    if (last) {
      float jump = 0.0f;
      for (std::size_t i = 0; i < layer.elements().size(); ++i)
        jump = std::max(jump, std::abs(layer.elements()[i].a - last->elements()[i].a));
      fmt::print("sum {:.1f}, largest step of a pixel {:.3f}\n", sum, double(jump));
      EXPECT_NEAR(sum / last_sum, 1.0, 0.02);
      EXPECT_LE(jump, 0.15f) << "coverage";
    }
    last = layer;
    last_sum = sum;
  }
}

TEST_F(Shadow, TheBoxContainsTheShadedGround) {
  ReferenceScene scene = gate_scene();
  Renderer renderer = loaded(scene);
  const PixelBox with = renderer.object_box();
  scene.model.ground.clear();
  load(renderer, scene);
  const PixelBox without = renderer.object_box();
  EXPECT_LE(with.left, without.left - 10);
  EXPECT_GE(with.right, without.right + 10);
  // Corners of the ground in view: cut by the picture, not by the near or far plane.
  EXPECT_EQ(with.bottom, 96);
}

TEST(SunFrame, ContainsTheModelInEveryMap) {
  const ModelBounds bounds{{-40, -2, -25}, {30, 33, 50}};
  const auto to_world = model_to_world({306, 3487, -39, from_degrees(24), 1.3});
  for (const double elevation : {-1.0, 0.0, 2.0, 30.0, 60.0, 89.0, 90.0})
    for (const double azimuth : {0.0, 77.0, 181.0, 300.0}) {
      const glm::dvec3 sun = sun_at(elevation, azimuth);
      const SunFrame frame = make_sun_frame(bounds, to_world, sun, 512);
      for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 at{corner & 1 ? bounds.highest.x : bounds.lowest.x,
                            corner & 2 ? bounds.highest.y : bounds.lowest.y,
                            corner & 4 ? bounds.highest.z : bounds.lowest.z};
        const glm::dvec3 seen(frame.from_model * glm::dvec4(at, 1.0));
        EXPECT_GE(seen.z, 0.0099);
        EXPECT_LE(seen.z, 0.9901);
        for (const glm::dvec2 edge : {glm::dvec2{1, 1}, {1, -1}, {-1, 1}, {-1, -1}}) {
          const glm::dvec2 place = glm::dvec2(seen) + (seen.z - 0.5) * frame.spread * edge + 256.0;
          EXPECT_GE(std::min(place.x, place.y), 2.0) << "texels, of the border left free";
          EXPECT_LE(std::max(place.x, place.y), 510.0);
        }
        // Nearer to the sun is less deep, by metres.
        const glm::dvec3 nearer(frame.from_model * glm::dvec4(at + glm::inverse(glm::dmat3(to_world)) * sun, 1.0));
        EXPECT_NEAR((seen.z - nearer.z) * frame.depth_m, 1.0, 1e-6);
        EXPECT_NEAR(glm::length(glm::dvec2(nearer - seen)), 0.0, 1e-6);
      }
      // The penumbra is that of the disc: .2665 deg either way over the depth.
      const double texel_m = 1.0 / glm::length(glm::dvec3(glm::transpose(frame.from_world)[0]));
      EXPECT_NEAR(frame.spread.x * texel_m / frame.depth_m, std::tan(from_degrees(0.2665).value), 1e-9);
    }
}

}  // namespace
}  // namespace kasumi
