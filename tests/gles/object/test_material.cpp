// The GPU's pictures of glTF materials against the reference: each map, each blend mode, each light.
#include <algorithm>
#include <cmath>

#include <GLES2/gl2.h>
#include <glm/geometric.hpp>

#include "gles/model/mip_levels.hpp"
#include "tests/gles/scenes.hpp"

namespace kasumi {
namespace {

// Balls in two rows before the camera, one material each, 3 km away and 26 pixels wide.
ReferenceScene balls(const std::vector<ModelMaterial>& materials) {
  ReferenceScene scene = box_scene();
  scene.model = {};
  scene.model.name = "balls";
  scene.model.materials = materials;
  const int columns = (static_cast<int>(materials.size()) + 1) / 2;
  for (int i = 0; i < static_cast<int>(materials.size()); ++i)
    scene.model.parts.push_back(
        ball_part({17.0 * (i % columns) - 8.5 * (columns - 1), 8.0 + 17.0 * (i / columns), 0}, 6.5, 32, i));
  scene.model_to_world = model_to_world({0, 3000, -16, {}, 1.0});
  return scene;
}

ModelMaterial gloss(double roughness, glm::vec4 colour, double metallic) {
  ModelMaterial material;
  material.name = "gloss";
  material.base_colour = colour;
  material.metallic = static_cast<float>(metallic);
  material.roughness = static_cast<float>(roughness);
  material.reflectance = glm::vec3(0.04f);
  material.edge_reflectance = 1.0f;
  return material;
}

// A box whose material has every map, two of them with their own texture transform.
ReferenceScene dressed_box() {
  ReferenceScene scene = box_scene();
  scene.model.textures = {soft_texture(32), soft_normals(16), soft_data(16), soft_texture(8)};
  ModelMaterial& material = scene.model.materials[0];
  material = gloss(0.9, {0.9f, 0.8f, 0.7f, 1.0f}, 0.6);
  material.texture = 0;
  material.normal_map = {1, false};
  material.normal_scale = 0.8f;
  material.roughness_map = {2, false};
  material.occlusion_map = {2, true};
  material.occlusion_strength = 0.7f;
  material.emission = {0.1f, 0.05f, 0.2f};
  material.emission_map = {3, true};
  return scene;
}

class MaterialAgainstReference : public GlesTest {};

TEST_F(MaterialAgainstReference, MetalsFromPolishedToMatt) {
  std::vector<ModelMaterial> metals;
  for (const double roughness : {0.15, 0.3, 0.45, 0.6, 0.8, 1.0})
    metals.push_back(gloss(roughness, {0.95f, 0.75f, 0.35f, 1.0f}, 1.0));
  expect_same(balls(metals), {{}}, 46.0);  // the table's 8 bits, and glints of one sample
}

TEST_F(MaterialAgainstReference, PaintFromPolishedToMatt) {
  std::vector<ModelMaterial> paints;
  for (const double roughness : {0.2, 0.3, 0.45, 0.6, 0.8, 1.0})
    paints.push_back(gloss(roughness, {0.5f, 0.08f, 0.05f, 1.0f}, 0.0));
  expect_same(balls(paints), {{}}, 46.0);
}

TEST_F(MaterialAgainstReference, CoatingsOfHighAndLowReflectance) {
  std::vector<ModelMaterial> coats;
  for (const float reflectance : {0.0f, 0.02f, 0.1f, 0.3f}) {
    coats.push_back(gloss(0.5, {0.3f, 0.3f, 0.4f, 1.0f}, 0.0));
    coats.back().reflectance = glm::vec3(reflectance, 0.5f * reflectance, reflectance);
    coats.back().edge_reflectance = 0.5f + reflectance;
  }
  expect_same(balls(coats), {{}}, 46.0);
}

TEST_F(MaterialAgainstReference, EveryMapAtOnce) {
  expect_same(dressed_box(), {{}, {.force_encoded_textures = true}}, 46.0);
}

TEST_F(MaterialAgainstReference, EveryMapAtOnceIntoEightBits) {
  expect_same(dressed_box(), {{.force_rgba8 = true}}, 44.0);
}

TEST_F(MaterialAgainstReference, EachMapAlone) {
  const auto alone = [&](auto wear) {
    ReferenceScene scene = dressed_box();
    ModelMaterial matt;
    matt.base_colour = {0.6f, 0.5f, 0.45f, 1.0f};
    wear(matt, scene.model.materials[0]);
    scene.model.materials[0] = matt;
    expect_same(scene);
  };
  alone([](ModelMaterial& to, const ModelMaterial& from) { to.normal_map = from.normal_map; });
  alone([](ModelMaterial& to, const ModelMaterial& from) {
    to.normal_map = from.normal_map;
    to.normal_map.second = true;
    to.normal_scale = -1.3f;
  });
  alone([](ModelMaterial& to, const ModelMaterial& from) { to.occlusion_map = from.occlusion_map; });
  alone([](ModelMaterial& to, const ModelMaterial& from) { to.emission = from.emission; });
  alone([](ModelMaterial& to, const ModelMaterial& from) {
    to.emission = 5.0f * from.emission;
    to.emission_map = from.emission_map;
  });
}

TEST_F(MaterialAgainstReference, TheBackOfASheetWithReliefAndGloss) {
  ReferenceScene scene = dressed_box();
  scene.model.materials[0].double_sided = true;
  auto& indices = scene.model.parts[0].indices;
  indices.erase(indices.begin(), indices.begin() + 6 * 16);  // the walls towards the camera
  scene.model_to_world = model_to_world({5, 3500, -12, from_degrees(20), 1.0});
  expect_same(scene, {{}}, 46.0);
}

TEST_F(MaterialAgainstReference, UnlitMaterialKeepsItsColourInAnyLight) {
  ReferenceScene scene = box_scene();
  scene.model.textures.push_back(soft_texture(32));
  scene.model.materials[0].texture = 0;
  scene.model.materials[0].unlit = true;
  expect_same(scene, {{}, {.force_rgba8 = true}});
  scene.appearance.light.sun_direction = glm::normalize(glm::dvec3{0.3, 0.8, -0.2});  // below the horizon
  expect_same(scene);
}

// Bright leaves, of another colour each, on what is transparent and black, as painting programs leave it.
TEST_F(MaterialAgainstReference, LeavesHaveNoFringesOfWhatIsTransparent) {
  constexpr int kSize = 16;
  ModelTexture leaves{Image<glm::u8vec4>(kSize, kSize, glm::u8vec4{0, 0, 0, 0})};
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x)
      if (std::hypot(x % 4 - 1.5, y % 4 - 1.5) < 1.7)
        leaves.pixels.at(x, y) = {200 + 5 * (x / 4), 240 - 4 * (y / 4), 150, 255};
  for (const auto kind : {ModelMaterial::Alpha::blend, ModelMaterial::Alpha::mask}) {
    ReferenceScene scene = box_scene();
    scene.model.textures = {leaves};
    scene.model.materials[0].texture = 0;
    scene.model.materials[0].alpha = kind;
    make_levels(scene.model);
    expect_same(scene, {{}, {.force_encoded_textures = true}}, 46.0);
  }
}

TEST_F(MaterialAgainstReference, AMirroredModelKeepsItsRelief) {
  ReferenceScene scene = dressed_box();
  ModelMaterial matt;
  matt.normal_map = scene.model.materials[0].normal_map;
  scene.model.materials[0] = matt;
  // Mirrored twice, in the model and by its placement, so that it looks unmirrored.
  const Image<Rgb8> camera = landscape(160, 120);
  const auto reference = render_reference(scene, camera, turned_lattice());
  for (ModelVertex& vertex : scene.model.parts[0].vertices) {
    vertex.position.x = -vertex.position.x;
    vertex.normal.x = -vertex.normal.x;
    vertex.tangent.x = -vertex.tangent.x;
    vertex.tangent.w = -vertex.tangent.w;
  }
  auto& indices = scene.model.parts[0].indices;
  for (std::size_t i = 0; i + 2 < indices.size(); i += 3) std::swap(indices[i + 1], indices[i + 2]);
  scene.model_to_world[0] = -scene.model_to_world[0];
  Renderer renderer = loaded(scene);
  expect_like(draw(renderer, scene.measured, view_of(camera)), reference);
}

TEST_F(MaterialAgainstReference, AMovingViewShowsTheSameMaterials) {
  GLint units = 0;
  glGetIntegerv(GL_MAX_TEXTURE_IMAGE_UNITS, &units);
  if (units < 12) GTEST_SKIP() << info().renderer << " has " << units << " texture units";
  ReferenceScene scene = dressed_box();
  scene.by_mask = true;
  scene.mask = Image<std::uint8_t>(scene.view.width, scene.view.height, 255);
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 160; ++x) scene.mask.at(x, y) = static_cast<std::uint8_t>(std::clamp((x - 50) * 4, 0, 255));
  const Image<Rgb8> camera = landscape(scene.view.width, scene.view.height);
  const auto reference = render_reference(scene, camera, pixel_centre());
  Renderer renderer = loaded(scene);
  EXPECT_THAT(renderer.notes(), testing::Not(testing::Contains(testing::HasSubstr("texture units"))));
  for (const auto detail : {HazeDetail::per_vertex, HazeDetail::per_fragment})
    expect_like(draw_moving(renderer, scene, view_of(camera), detail), reference, 46.0);
}

TEST_F(MaterialAgainstReference, PanesOfTwoKindsAreVisibleThroughEachOther) {
  // Panes of alternating tint one behind the other, stored by kind and near to far: any draw order but back to front
  // gives other colours.
  ReferenceScene scene = box_scene();
  for (int kind = 0; kind < 2; ++kind)
    scene.model.materials.push_back(
        {.name = "glass",
         .base_colour = kind == 0 ? glm::vec4(0.9f, 0.1f, 0.1f, 0.5f) : glm::vec4(0.1f, 0.2f, 0.9f, 0.5f),
         .alpha = ModelMaterial::Alpha::blend,
         .double_sided = true});
  for (int kind = 0; kind < 2; ++kind)
    for (int pane = 0; pane < 4; ++pane) {
      ModelPart part = box_part({-30, 5, 0}, {30, 50, 1}, 1, 1 + kind);
      part.indices.resize(6);  // the face towards +z
      for (ModelVertex& vertex : part.vertices)
        vertex.position.z = 45.0f + 20.0f * float(3 - pane) + 10.0f * float(kind);
      scene.model.parts.push_back(std::move(part));
    }
  scene.model_to_world = model_to_world({5, 3500, -12, from_degrees(8), 1.0});
  expect_same(scene);
  // From the other side the order is the reverse.
  scene.model_to_world = model_to_world({5, 3500, -12, from_degrees(188), 1.0});
  expect_same(scene);
}

}  // namespace
}  // namespace kasumi
