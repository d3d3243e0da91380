// The GPU's pictures against the reference: physics, geometry and light.
#include <cmath>

#include "tests/gles/scenes.hpp"

namespace kasumi {
namespace {

class RendererAgainstReference : public GlesTest {};

TEST_F(RendererAgainstReference, DrawsAPlainBox) {
  expect_same(box_scene(), {{}, {.force_rgba8 = true}});
}

TEST_F(RendererAgainstReference, DrawsATexturedBoxAlsoWhereTheDriverDoesNotDecode) {
  ReferenceScene scene = box_scene();
  scene.model.textures.push_back(soft_texture(32));
  scene.model.materials[0].texture = 0;
  expect_same(scene, {{}, {.force_encoded_textures = true}});
}

TEST_F(RendererAgainstReference, RepeatsAndMirrorsTextures) {
  ReferenceScene scene = box_scene();
  ModelTexture texture = soft_texture(16);
  texture.wrap_s = TextureWrap::mirrored_repeat;
  scene.model.textures.push_back(texture);
  scene.model.materials[0].texture = 0;
  for (ModelVertex& vertex : scene.model.parts[0].vertices) vertex.texture = 1.7f * vertex.texture - 0.4f;
  expect_same(scene);
}

TEST_F(RendererAgainstReference, DrawsColumnsThinnerThanAPixel) {
  ReferenceScene scene = box_scene();
  scene.model = columns_model(14, 0.3, 5.0, 30.0);  // half a pixel wide
  expect_same(scene, {{}, {.force_rgba8 = true}});
}

TEST_F(RendererAgainstReference, FollowsTheLensDistortion) {
  ReferenceScene scene = box_scene();
  scene.model = box_model(60, 40, 60, 48);  // edges bend between vertices, so they are close together
  scene.view.focal_px = {200, 200};
  scene.view.near_m = 10.0;
  scene.view.distortion = {-0.28, 0.11, 0.02, -0.015, -0.02};  // tangentially more than real lenses
  scene.model_to_world = model_to_world({5, 130, -12, from_degrees(30), 1.0});
  scene.appearance = afternoon(scene.view);
  scene.measured = measured_airlight(scene.view);
  expect_same(scene);
}

TEST_F(RendererAgainstReference, FollowsASightLineUpAMountain) {
  ReferenceScene scene = box_scene();
  // 25 km away and 3 km up, seen by a camera that looks up at it: density along the path falls by a factor of 10.
  scene.model_to_world = model_to_world({40, 25000, 3000, from_degrees(30), 7.0});
  const double pitch = std::atan2(3000.0 + 140.0, 25000.0);
  scene.view.world_to_camera = glm::dmat4({1, 0, 0, 0}, {0, std::sin(pitch), std::cos(pitch), 0},
                                          {0, -std::cos(pitch), std::sin(pitch), 0}, {0, 0, 0, 1});
  expect_same(scene);
}

TEST_F(RendererAgainstReference, LooksDownIntoTheValley) {
  ReferenceScene scene = box_scene();
  scene.appearance.haze.observer_altitude_m = 2400.0;
  scene.model_to_world = model_to_world({40, 9000, -2300, from_degrees(30), 2.5});
  const double pitch = std::atan2(-2250.0, 9000.0);
  scene.view.world_to_camera = glm::dmat4({1, 0, 0, 0}, {0, std::sin(pitch), std::cos(pitch), 0},
                                          {0, -std::cos(pitch), std::sin(pitch), 0}, {0, 0, 0, 1});
  expect_same(scene);
}

TEST_F(RendererAgainstReference, LeavesOutTheAirOnRequest) {
  ReferenceScene scene = box_scene();
  scene.appearance.aerial_perspective = false;
  expect_same(scene, {{}, {.force_rgba8 = true}});
}

TEST_F(RendererAgainstReference, SaturatesTheObjectAsTheCameraSaturatesTheRest) {
  ReferenceScene scene = box_scene();
  for (const double saturation : {0.6, 1.8}) {
    scene.measured.saturation = saturation;
    expect_same(scene, {{}, {.force_rgba8 = true}});
  }
  scene.mask = Image<std::uint8_t>(scene.view.width, scene.view.height, 255);
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 80; ++x) scene.mask.at(x, y) = static_cast<std::uint8_t>(std::max(0, (x - 60) * 255 / 20));
  expect_same(scene, {{}}, 48.0);
}

TEST_F(RendererAgainstReference, ShowsTheForegroundThroughASoftMask) {
  ReferenceScene scene = box_scene();
  scene.mask = Image<std::uint8_t>(scene.view.width, scene.view.height, 255);
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 80; ++x) scene.mask.at(x, y) = static_cast<std::uint8_t>(std::max(0, (x - 60) * 255 / 20));
  expect_same(scene, {{}, {.force_rgba8 = true}}, 48.0);  // its nodes have 8 bits
}

// So much of it that whole rectangles are drawn without a look at the mask, were they not left out before.
TEST_F(RendererAgainstReference, ShowsTheForegroundThatHidesMostOfTheObject) {
  ReferenceScene scene = box_scene();
  scene.mask = Image<std::uint8_t>(scene.view.width, scene.view.height, 255);
  for (int y = 0; y < scene.view.height; ++y)
    for (int x = 0; x < 110; ++x) scene.mask.at(x, y) = 0;
  expect_same(scene, {{}, {.force_rgba8 = true}});
}

TEST_F(RendererAgainstReference, ClipsAnObjectAtThePicturesBorder) {
  ReferenceScene scene = box_scene();
  scene.model_to_world = model_to_world({-45, 3500, 20, from_degrees(10), 1.0});
  expect_same(scene);
}

TEST_F(RendererAgainstReference, ClipsAnObjectAtTheNearPlane) {
  ReferenceScene scene = box_scene();
  // A wall that begins next to the camera and runs past the near plane into the distance.
  scene.model = {};
  scene.model.materials.push_back({.name = "wall", .base_colour = {0.5f, 0.5f, 0.4f, 1.0f}});
  scene.model.parts.push_back(box_part({60, -40, -1200}, {80, 30, 20}, 24));
  scene.view.focal_px = {120, 120};
  scene.view.near_m = 150.0;
  scene.model_to_world = model_to_world({0, 0, 0, {}, 1.0});
  expect_same(scene);
}

TEST_F(RendererAgainstReference, LightsBothSidesOfASheet) {
  ReferenceScene scene = box_scene();
  scene.model.materials[0].double_sided = true;
  // Only the two upright faces that look away from the camera are left: their inner sides are visible.
  auto& indices = scene.model.parts[0].indices;
  indices.erase(indices.begin(), indices.begin() + 6 * 16);
  scene.model_to_world = model_to_world({5, 3500, -12, from_degrees(20), 1.0});
  expect_same(scene);
}

TEST_F(RendererAgainstReference, CutsOutWhatAlphaMasks) {
  ReferenceScene scene = box_scene();
  ModelTexture texture = soft_texture(32);
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 32; ++x)
      texture.pixels.at(x, y).a = static_cast<std::uint8_t>(
          std::clamp(127.0 + 900.0 * std::sin(2 * kPi * x / 32.0) * std::cos(2 * kPi * y / 32.0), 0.0, 255.0));
  scene.model.textures.push_back(texture);
  scene.model.materials[0].texture = 0;
  // Roof and floor are seen at a grazing angle, where smaller mipmaps are used: not under test here.
  auto& indices = scene.model.parts[0].indices;
  indices.resize(indices.size() * 4 / 6);
  scene.model.materials[0].alpha = ModelMaterial::Alpha::mask;
  scene.model.materials[0].alpha_cutoff = 0.45f;
  scene.model.materials[0].double_sided = true;
  expect_same(scene);
}

TEST_F(RendererAgainstReference, BlendsGlassOverABox) {
  ReferenceScene scene = box_scene();
  scene.model.materials.push_back(
      {.name = "glass", .base_colour = {0.2f, 0.4f, 0.5f, 0.35f}, .alpha = ModelMaterial::Alpha::blend});
  scene.model.parts.push_back(box_part({-25, 5, 35}, {35, 45, 45}, 1, 1));
  expect_same(scene, {{}, {.force_rgba8 = true}});
}

TEST_F(RendererAgainstReference, MultipliesVertexColours) {
  ReferenceScene scene = box_scene();
  for (ModelVertex& vertex : scene.model.parts[0].vertices)
    vertex.colour = {0.5f + vertex.position.x / 80.0f, vertex.position.y / 40.0f, 0.7f, 1.0f};
  expect_same(scene);
}

TEST_F(RendererAgainstReference, EncodesWithTheCamerasResponse) {
  ReferenceScene scene = box_scene();
  scene.response.kind = ResponseCurve::Kind::linear;
  expect_same(scene);
  scene.response.kind = ResponseCurve::Kind::table;
  for (std::size_t c = 0; c < 3; ++c)
    for (int i = 0; i <= 255; ++i) scene.response.light[c].push_back(std::pow(i / 255.0, 1.8 + 0.3 * double(c)));
  expect_same(scene, {{}, {.force_rgba8 = true}});
}

TEST_F(RendererAgainstReference, AgreesInDenseHazeAndInNone) {
  ReferenceScene scene = box_scene();
  for (auto& mie : scene.appearance.haze.mie_per_m) mie *= 12.0;
  expect_same(scene, {{}, {.force_rgba8 = true}});
  for (auto& mie : scene.appearance.haze.mie_per_m) mie *= 0.0;
  expect_same(scene);
}

TEST_F(RendererAgainstReference, DrawsTheFootOfTheObjectInValleyFog) {
  ReferenceScene scene = box_scene();
  // Faces small against the fog's scale height: the fog's optical depth is linear between vertices.
  scene.model = box_model(60, 40, 60, 40);
  Haze& haze = scene.appearance.haze;
  haze.fog_base_altitude_m = haze.observer_altitude_m - 20.0;
  haze.fog_scale_height_m = 15.0;
  haze.fog_per_m = 2e-3;
  expect_same(scene, {{}, {.force_rgba8 = true}});
  haze.fog_base_altitude_m -= 6000.0;  // far below: nothing is seen of it
  expect_same(scene);
  haze.fog_base_altitude_m += 7000.0;  // deep in it nothing else is seen
  expect_same(scene);
}

TEST_F(RendererAgainstReference, AntialiasesEdgesLikeManySamples) {
  // 17 samples against 1024: a straight edge's coverage is off by at most 1/17, which between building and sky of this
  // scene is a few steps; 42 dB on all covered pixels together.
  ReferenceScene scene = box_scene();
  const Image<Rgb8> camera = landscape(scene.view.width, scene.view.height);
  Renderer renderer = loaded(scene);
  const auto reference = render_reference(scene, camera, upright_grid(8));
  const auto layer = renderer.read_layer();
  ASSERT_OK(layer);
  const PixelBox box = renderer.object_box();
  double worst = 0.0;
  for (int y = box.top; y < box.bottom; ++y)
    for (int x = box.left; x < box.right; ++x)
      worst = std::max(worst, std::abs(double(layer->at(x - box.left, y - box.top).a) - reference.layer.at(x, y).a));
  EXPECT_LE(worst, 0.12);
  expect_like(draw(renderer, scene.measured, view_of(camera)), reference, 48.0);
}

TEST_F(RendererAgainstReference, DrawsAMovingViewInOnePass) {
  ReferenceScene scene = box_scene();
  const Image<Rgb8> camera = landscape(scene.view.width, scene.view.height);
  Renderer renderer = loaded(scene);
  const auto reference = render_reference(scene, camera, pixel_centre());
  expect_like(draw_moving(renderer, scene, view_of(camera), HazeDetail::per_fragment), reference);
  expect_like(draw_moving(renderer, scene, view_of(camera), HazeDetail::per_vertex), reference);
}

TEST_F(RendererAgainstReference, DrawsAMovingViewBehindAForegroundAndWithoutAir) {
  ReferenceScene scene = box_scene();
  scene.by_mask = true;
  scene.mask = Image<std::uint8_t>(scene.view.width, scene.view.height, 255);
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 160; ++x) scene.mask.at(x, y) = static_cast<std::uint8_t>(std::clamp((x - 50) * 4, 0, 255));
  const Image<Rgb8> camera = landscape(scene.view.width, scene.view.height);
  Renderer renderer = loaded(scene);
  expect_like(draw_moving(renderer, scene, view_of(camera), HazeDetail::per_vertex),
              render_reference(scene, camera, pixel_centre()));
  scene.appearance.aerial_perspective = false;
  expect_like(draw_moving(renderer, scene, view_of(camera), HazeDetail::per_vertex),
              render_reference(scene, camera, pixel_centre()));
}

}  // namespace
}  // namespace kasumi
