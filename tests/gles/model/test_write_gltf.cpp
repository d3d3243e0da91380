// What is written as glTF is read again as it was; what is made coarser stays within its bounds.
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "base/files.hpp"
#include "base/picture_files/picture_file.hpp"
#include "gles/model/coarser_model.hpp"
#include "gles/model/mip_levels.hpp"
#include "gles/model/write_gltf.hpp"
#include "tests/gles/model/gltf_writer.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

Model written_and_read(const Model& model, bool text, const std::string& name) {
  std::vector<std::vector<std::uint8_t>> pictures;
  for (const auto& texture : model.textures) pictures.push_back(encode_png(texture.pixels).value());
  const auto file = model_folder() / (name + (text ? ".gltf" : ".glb"));
  const WrittenScene scene{"", &model};
  EXPECT_TRUE(write_file(file, gltf_of(std::span(&scene, 1), 0, pictures, text)));
  return loaded(read_gltf(file));
}

void expect_same_material(const Model& one, int a, const Model& other, int b) {
  const auto& is = other.materials.at(static_cast<std::size_t>(b));
  const auto& was = one.materials.at(static_cast<std::size_t>(a));
  EXPECT_EQ(is.name, was.name);
  EXPECT_EQ(is.base_colour, was.base_colour) << was.name;
  EXPECT_EQ(is.alpha, was.alpha);
  EXPECT_EQ(is.alpha_cutoff, was.alpha_cutoff);
  EXPECT_EQ(is.double_sided, was.double_sided);
  EXPECT_EQ(is.metallic, was.metallic);
  EXPECT_EQ(is.roughness, was.roughness);
  EXPECT_EQ(is.unlit, was.unlit);
  EXPECT_LT(glm::distance(is.reflectance, was.reflectance), 1e-6f);
  EXPECT_EQ(is.edge_reflectance, was.edge_reflectance);
  EXPECT_EQ(is.normal_scale, was.normal_scale);
  EXPECT_EQ(is.occlusion_strength, was.occlusion_strength);
  EXPECT_LT(glm::distance(is.emission, was.emission), 1e-5f);
  const auto same_picture = [&](MaterialMap x, MaterialMap y, const char* what) {
    ASSERT_EQ(x.used(), y.used()) << what;
    if (!x.used()) return;
    EXPECT_EQ(x.second, y.second) << what;
    const auto& from = one.textures.at(static_cast<std::size_t>(x.texture));
    const auto& to = other.textures.at(static_cast<std::size_t>(y.texture));
    EXPECT_EQ(from.pixels.elements(), to.pixels.elements()) << what;
    EXPECT_EQ(from.wrap_s, to.wrap_s);
    EXPECT_EQ(from.wrap_t, to.wrap_t);
    EXPECT_EQ(from.nearest, to.nearest);
    EXPECT_EQ(from.data, to.data);
  };
  same_picture({was.texture, false}, {is.texture, false}, "colour");
  same_picture(was.roughness_map, is.roughness_map, "roughness");
  same_picture(was.normal_map, is.normal_map, "normal");
  same_picture(was.occlusion_map, is.occlusion_map, "occlusion");
  same_picture(was.emission_map, is.emission_map, "emission");
}

void expect_same(const Model& was, const Model& is) {
  const auto parts = [&](const std::vector<ModelPart>& from, const std::vector<ModelPart>& to) {
    ASSERT_EQ(from.size(), to.size());
    for (std::size_t i = 0; i < from.size(); ++i) {
      EXPECT_EQ(from[i].indices, to[i].indices);
      ASSERT_EQ(from[i].vertices.size(), to[i].vertices.size());
      expect_same_material(was, from[i].material, is, to[i].material);
      float off = 0.0f;
      for (std::size_t v = 0; v < from[i].vertices.size(); ++v) {
        const ModelVertex &a = from[i].vertices[v], &b = to[i].vertices[v];
        EXPECT_EQ(a.position, b.position);
        off = std::max({off, glm::distance(a.normal, b.normal), glm::distance(a.colour, b.colour),
                        glm::distance(a.tangent, b.tangent)});
        const auto& material = was.materials[static_cast<std::size_t>(from[i].material)];
        if (material.texture >= 0) off = std::max(off, glm::distance(a.texture, b.texture));
        if (material.occlusion_map.second) off = std::max(off, glm::distance(a.texture_2, b.texture_2));
      }
      EXPECT_LT(off, 1e-4f);
    }
  };
  parts(was.parts, is.parts);
  parts(was.ground, is.ground);
}

TEST(WriteGltf, PlacesKeepTheirNamesAndBoxes) {
  Model model = loaded(read_gltf(source_folder() / "fixtures/temple.glb"));
  ASSERT_EQ(model.nodes.size(), 2u);
  const auto temple = std::ranges::find(model.nodes, "temple", &ModelNode::name);
  ASSERT_NE(temple, model.nodes.end());
  EXPECT_EQ(temple->bounds.lowest, model.bounds().lowest);
  EXPECT_EQ(temple->bounds.highest, model.bounds().highest);
  model.nodes = {{"gate", {{-2.0f, 0.25f, 1.0f}, {3.0f, 4.5f, 1.0f}}}};
  for (const bool text : {false, true}) {
    const Model read = written_and_read(model, text, "places");
    const auto gate = std::ranges::find(read.nodes, "gate", &ModelNode::name);
    ASSERT_NE(gate, read.nodes.end());
    EXPECT_EQ(gate->bounds.lowest, model.nodes[0].bounds.lowest);
    EXPECT_EQ(gate->bounds.highest, model.nodes[0].bounds.highest);
    EXPECT_EQ(read.triangle_count(), model.triangle_count());
  }
}

TEST(WriteGltf, OurBuildingsComeBackAsTheyWere) {
  for (const char* name : {"temple", "pagoda"}) {
    const auto model = loaded(read_gltf(source_folder() / "fixtures" / (std::string(name) + ".glb")));
    for (const bool text : {false, true}) expect_same(model, written_and_read(model, text, name));
  }
}

TEST(WriteGltf, EveryKindOfMaterialComesBack) {
  GltfFile file = square_file();
  file.primitive()["material"] = 0;
  file.primitive()["attributes"]["TEXCOORD_0"] = file.add_floats({0, 0, 1, 0, 1, 1, 0, 1}, 2);
  file.primitive()["attributes"]["TEXCOORD_1"] = file.add_floats({0, 0, .5, 0, .5, .5, 0, .5}, 2);
  file.primitive()["attributes"]["NORMAL"] = file.add_floats({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, 3);
  file.primitive()["attributes"]["COLOR_0"] =
      file.add_floats({.1f, .2f, .3f, 1, 1, 1, 1, .5f, 0, 0, 0, 1, 1, 0, 1, 1}, 4);
  Image<glm::u8vec4> picture(4, 2);
  for (int x = 0; x < 4; ++x)
    for (int y = 0; y < 2; ++y) picture.at(x, y) = {60 * x, 100 * y, 7, 255 - 20 * x};
  file.add_picture(encode_png(picture).value());
  file.json["samplers"] = {{{"magFilter", 9728}, {"wrapS", 33071}, {"wrapT", 33648}}};
  file.json["textures"][0]["sampler"] = 0;
  const nlohmann::json first{{"index", 0}}, second{{"index", 0}, {"texCoord", 1}};
  const nlohmann::json surface{{"baseColorTexture", first},
                               {"metallicRoughnessTexture", second},
                               {"metallicFactor", .4},
                               {"roughnessFactor", .3},
                               {"baseColorFactor", {.9, .8, .7, .6}}};
  const std::vector<nlohmann::json> materials{
      {{"name", "all"},
       {"pbrMetallicRoughness", surface},
       {"alphaMode", "MASK"},
       {"alphaCutoff", .3},
       {"doubleSided", true},
       {"normalTexture", {{"index", 0}, {"scale", .7}}},
       {"occlusionTexture", {{"index", 0}, {"texCoord", 1}, {"strength", .6}}},
       {"emissiveTexture", first},
       {"emissiveFactor", {.5, .25, 1}},
       {"extensions", {{"KHR_materials_emissive_strength", {{"emissiveStrength", 4}}}}}},
      {{"name", "unlit"},
       {"pbrMetallicRoughness", surface},
       {"alphaMode", "BLEND"},
       {"extensions", {{"KHR_materials_unlit", nlohmann::json::object()}}}},
      {{"name", "diamond"}, {"extensions", {{"KHR_materials_ior", {{"ior", 2.4}}}}}},
      {{"name", "specular"},
       {"extensions", {{"KHR_materials_specular", {{"specularFactor", .5}, {"specularColorFactor", {1, .5, 2}}}}}}},
      {{"name", "older"},
       {"extensions",
        {{"KHR_materials_pbrSpecularGlossiness",
          {{"diffuseTexture", first}, {"specularGlossinessTexture", first}, {"glossinessFactor", .5}}}}}}};
  for (const auto& material : materials) {
    file.json["materials"] = {material};
    const auto model = loaded(file.read("material"));
    expect_same(model, written_and_read(model, false, "material-written"));
  }
}

// A rough ball of two times `steps` squared triangles with a texture, each of its triangles with corners of its own.
Model ball(int steps) {
  Model model;
  model.materials.resize(1);
  model.materials[0].texture = 0;
  model.textures.resize(1);
  model.textures[0].pixels = Image<glm::u8vec4>(512, 512, glm::u8vec4(200, 90, 30, 255));
  make_levels(model);
  auto& part = model.parts.emplace_back();
  const auto at = [&](int x, int y) {
    const double turn = 2.0 * 3.14159265358979 * x / steps, down = 3.14159265358979 * y / steps;
    const double radius = 10.0 + 0.02 * std::sin(77.0 * turn) * std::sin(55.0 * down);
    const glm::dvec3 out{std::sin(down) * std::sin(turn), std::cos(down), std::sin(down) * std::cos(turn)};
    return ModelVertex{.position = glm::vec3(radius * out), .texture = {double(x) / steps, double(y) / steps}};
  };
  for (int y = 0; y < steps; ++y)
    for (int x = 0; x < steps; ++x)
      for (const glm::ivec2 c : {glm::ivec2(0, 0), {0, 1}, {1, 1}, {0, 0}, {1, 1}, {1, 0}}) {
        part.indices.push_back(static_cast<std::uint32_t>(part.vertices.size()));
        part.vertices.push_back(at(x + c.x, y + c.y));
      }
  for (std::size_t i = 0; i < part.vertices.size(); i += 3) {
    const glm::vec3 a = part.vertices[i].position, b = part.vertices[i + 1].position, c = part.vertices[i + 2].position;
    const glm::vec3 across = glm::cross(b - a, c - a);
    for (std::size_t k = 0; k < 3; ++k)
      part.vertices[i + k].normal = glm::normalize(glm::length(across) > 1e-9f ? across : a);
  }
  return model;
}

TEST(CoarserModel, ItKeepsWithinItsErrorAndItsTexels) {
  const Model fine = ball(200);
  const auto made = coarser({fine}, {0.2, 0.4, 0.5});
  ASSERT_TRUE(made) << made.error().message;
  const Model& coarse = made->front();
  EXPECT_TRUE(check(coarse));
  EXPECT_LT(coarse.triangle_count(), 4000u);
  EXPECT_GT(coarse.triangle_count(), 100u);
  // Away from the poles, where the roughness of the one is steep.
  const auto mean_tilt = [](const ModelPart& part) {
    double sum = 0.0;
    int count = 0;
    for (const ModelVertex& vertex : part.vertices)
      if (std::abs(vertex.position.y) < 8.0f) {
        sum += std::acos(std::min(1.0, double(glm::dot(vertex.normal, glm::normalize(vertex.position)))));
        ++count;
      }
    return sum / count;
  };
  fmt::print("normals off by {:.3f}, before {:.3f}\n", mean_tilt(coarse.parts[0]), mean_tilt(fine.parts[0]));
  EXPECT_LT(mean_tilt(coarse.parts[0]), 0.5 * mean_tilt(fine.parts[0]));
  for (const ModelVertex& vertex : coarse.parts[0].vertices) EXPECT_NEAR(glm::length(vertex.position), 10.0f, 0.25f);
  const ModelPart& part = coarse.parts[0];
  for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3) {
    const glm::vec3 middle = (part.vertices[part.indices[i]].position + part.vertices[part.indices[i + 1]].position +
                              part.vertices[part.indices[i + 2]].position) /
                             3.0f;
    EXPECT_GT(glm::length(middle), 9.4f);
  }
  // Sixty metres round for 512 texels, at the equator; half of that down: texels of .12 and .06 m.
  EXPECT_GE(coarse.textures[0].pixels.width(), 64);
  EXPECT_LE(coarse.textures[0].pixels.width(), 256);
  EXPECT_EQ(coarse.textures[0].smaller.size(), static_cast<std::size_t>(std::log2(coarse.textures[0].pixels.width())));
}

TEST(CoarserModel, LargeTrianglesKeepTheirPlaceAndNormals) {
  const auto temple = loaded(read_gltf(source_folder() / "fixtures/temple.glb"));
  const auto made = coarser({temple}, {1e-4, 1e-3, 0.0});
  ASSERT_TRUE(made) << made.error().message;
  EXPECT_EQ(made->front().bounds().lowest, temple.bounds().lowest);
  EXPECT_EQ(made->front().bounds().highest, temple.bounds().highest);
  EXPECT_EQ(made->front().ground.size(), temple.ground.size());
  EXPECT_EQ(made->front().textures[0].pixels.elements(), temple.textures[0].pixels.elements());
  std::size_t hard = 0;  // corners whose normal nothing in the original has
  for (std::size_t p = 0; p < made->front().parts.size(); ++p)
    for (const ModelVertex& vertex : made->front().parts[p].vertices)
      hard += std::ranges::none_of(temple.parts[p].vertices, [&](const ModelVertex& v) {
        return v.position == vertex.position && v.normal == vertex.normal;
      });
  EXPECT_EQ(hard, 0u);
}

}  // namespace
}  // namespace kasumi
