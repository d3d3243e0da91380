// `kasumi look`: what a curator is told of a model before it goes to a kiosk; and that what is left out of it is told
// wherever it is read.
#include <cmath>
#include <cstring>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "pipeline/lab/look/model_facts.hpp"
#include "pipeline/lab/look/turntable.hpp"
#include "tests/gles/model/packed_files.hpp"
#include "tests/must.hpp"
#include "tests/picture_difference.hpp"
#include "tests/pipeline/kiosk/content/desk.hpp"
#include "tests/pipeline/run_kasumi.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
namespace fs = std::filesystem;

Model temple() {
  auto model = read_gltf(source_folder() / "fixtures/temple.glb");
  EXPECT_TRUE(model) << model.error().message;
  return model ? std::move(*model) : Model{};
}

// The same building as a program exports it whose z points up.
Model with_z_up(Model model) {
  for (auto* parts : {&model.parts, &model.ground})
    for (ModelPart& part : *parts)
      for (ModelVertex& vertex : part.vertices) {
        vertex.position = {vertex.position.x, -vertex.position.z, vertex.position.y};
        vertex.normal = {vertex.normal.x, -vertex.normal.z, vertex.normal.y};
      }
  return model;
}

// A wall that faces +z, standing: one side of a scan.
Model facade() {
  Model model;
  model.materials.emplace_back();
  ModelPart& wall = model.parts.emplace_back();
  for (const glm::vec2 at : {glm::vec2(0, 0), glm::vec2(20, 0), glm::vec2(20, 12), glm::vec2(0, 12)})
    wall.vertices.push_back({.position = {at.x, at.y, 0}, .normal = {0, 0, 1}});
  wall.indices = {0, 1, 2, 0, 2, 3};
  return model;
}

// The GLB with another JSON.
void edit_glb(const fs::path& file, const std::function<void(nlohmann::json&)>& edit) {
  const auto bytes = read_file(file).value();
  std::uint32_t length = 0;
  std::memcpy(&length, bytes.data() + 12, 4);
  auto json = nlohmann::json::parse(bytes.begin() + 20, bytes.begin() + 20 + length);
  edit(json);
  std::string text = json.dump();
  while (text.size() % 4 != 0) text += ' ';
  std::vector<std::uint8_t> made(bytes.begin(), bytes.begin() + 20);
  made.insert(made.end(), text.begin(), text.end());
  made.insert(made.end(), bytes.begin() + 20 + length, bytes.end());
  const auto whole = static_cast<std::uint32_t>(made.size());
  length = static_cast<std::uint32_t>(text.size());
  std::memcpy(made.data() + 8, &whole, 4);
  std::memcpy(made.data() + 12, &length, 4);
  ASSERT_TRUE(write_file(file, made));
}

TEST(Look, TellsWhichAxisSeemsToPointUp) {
  const Model standing = temple();
  EXPECT_FALSE(seems_z_up(standing));
  EXPECT_TRUE(seems_z_up(with_z_up(standing)));
  const auto pagoda = must(read_gltf(source_folder() / "fixtures/pagoda.glb"));
  EXPECT_FALSE(seems_z_up(*pagoda));
  EXPECT_TRUE(seems_z_up(with_z_up(*pagoda)));
  Model wall = facade();
  EXPECT_FALSE(seems_z_up(wall));  // faces z, but stands
  for (ModelVertex& vertex : wall.parts[0].vertices) vertex.position -= glm::vec3(10, 6, 0);
  EXPECT_FALSE(seems_z_up(wall));
}

TEST(Look, TellsWhatIsDoubtful) {
  Model model = temple();
  EXPECT_THAT(facts_of(model, UpAxis::y).doubts, testing::IsEmpty());
  EXPECT_THAT(facts_of(with_z_up(model), UpAxis::y).doubts, testing::ElementsAre(HasSubstr("up = \"z\"")));
  EXPECT_THAT(facts_of(with_z_up(model), UpAxis::z).doubts, testing::IsEmpty());
  for (ModelPart& part : model.parts)
    for (ModelVertex& vertex : part.vertices) vertex.position *= 100.0f;  // in centimetres
  EXPECT_THAT(facts_of(model, UpAxis::y).doubts, testing::ElementsAre(HasSubstr("scale = 0.01")));
}

TEST(Look, DoubtsAMapsCoordinates) {
  Model model = temple();
  for (ModelPart& part : model.parts)
    for (ModelVertex& vertex : part.vertices) vertex.position += glm::vec3(476'000, 100, 5'400'000);
  EXPECT_THAT(facts_of(model, UpAxis::y).doubts,
              testing::ElementsAre(AllOf(HasSubstr("5420.9 km from its origin"), HasSubstr("exact to 0.32 m"))));
}

TEST(Look, TellsSizeTrianglesAndGround) {
  const auto told = ended(0, run_kasumi("look " + (source_folder() / "fixtures/temple.glb").string()));
  EXPECT_THAT(told.out, AllOf(HasSubstr("84.00 m wide (x), 68.20 m deep, 46.20 m high (y up)"),
                              HasSubstr("8124 triangles"), HasSubstr("7 textures"), HasSubstr("ground: 608 triangles"),
                              HasSubstr("nothing was left out"), Not(HasSubstr("DOUBTFUL"))));
}

TEST(Look, TurnsTheModelRoundAndAZUpOneStandsUpright) {
  auto context = open_headless_context();
  if (!context) GTEST_SKIP() << context.error().message;
  const auto views = must(turntable(**context, temple(), UpAxis::y))->views;
  ASSERT_EQ(views.size(), 8u);
  const auto same = must(turntable(**context, with_z_up(temple()), UpAxis::z))->views;
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_LT(difference(views[i], same[i]).mean, 0.05) << i;
    EXPECT_GT(difference(views[i], views[(i + 1) % 8]).mean, 0.5) << i;
  }
}

// The model, its meshes written to a file in that packing and read back.
Model through_file(const Model& model, Packing packing) {
  GltfFile file;
  file.json["meshes"][0]["primitives"] = nlohmann::json::array();
  for (const ModelPart& part : model.parts) {
    PlainMesh mesh;
    for (const ModelVertex& vertex : part.vertices) {
      mesh.positions.insert(mesh.positions.end(), {vertex.position.x, vertex.position.y, vertex.position.z});
      mesh.normals.insert(mesh.normals.end(), {vertex.normal.x, vertex.normal.y, vertex.normal.z});
      mesh.texture.insert(mesh.texture.end(), {vertex.texture.x, vertex.texture.y});
    }
    mesh.indices = part.indices;
    add_primitive(file, mesh, packing);
    // A material with a picture, or its coordinates would not be read.
    file.json["meshes"][0]["primitives"].back()["material"] = 0;
  }
  std::vector<std::uint8_t> rgba(16, 255);
  file.json["images"] = {{{"uri", "data:image/webp;base64," + base64(webp_file(rgba, 2, 2))}}};
  file.json["textures"] = {{{"extensions", {{"EXT_texture_webp", {{"source", 0}}}}}}};
  file.json["materials"] = {{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}};
  Model read = loaded(file.read("packed"));
  EXPECT_EQ(read.parts.size(), model.parts.size());
  for (std::size_t i = 0; i < read.parts.size() && i < model.parts.size(); ++i)
    read.parts[i].material = model.parts[i].material;
  read.materials = model.materials;
  read.textures = model.textures;
  read.ground = model.ground;
  return read;
}

// A white model is not burnt out, a dark one does not drown.
TEST(Look, ASheetIsExposedForTheModel) {
  auto context = open_headless_context();
  if (!context) GTEST_SKIP() << context.error().message;
  double before = 0.0;
  for (const float grey : {0.95f, 0.05f}) {
    Model model = temple();
    for (ModelMaterial& material : model.materials) {
      material.texture = -1;
      material.base_colour = glm::vec4(glm::vec3(grey), 1.0f);
    }
    const auto turned = must(turntable(**context, model, UpAxis::y));
    std::size_t white = 0, bright = 0, all = 0;
    for (const auto& view : turned->views)
      for (const Rgb8& texel : view.elements()) {
        const int most = std::max({texel.r, texel.g, texel.b});
        white += most >= 253, bright += most >= 160, ++all;
      }
    EXPECT_LT(static_cast<double>(white), 0.006 * static_cast<double>(all)) << grey;
    EXPECT_GT(static_cast<double>(bright), 0.004 * static_cast<double>(all)) << grey;
    EXPECT_GT(turned->exposure, before) << grey;
    before = turned->exposure;
  }
}

TEST(Look, ACompressedModelLooksLikeTheSameUncompressed) {
  auto context = open_headless_context();
  if (!context) GTEST_SKIP() << context.error().message;
  const Model plain = temple();
  const auto views = must(turntable(**context, plain, UpAxis::y))->views;
  // Of 255, over the whole picture, a sixth of which or more is the building. meshopt may turn a triangle's corners round.
  for (const auto& [packing, most] :
       {std::pair{Packing::none, 0.0}, {Packing::meshopt, 1e-3}, {Packing::draco, 0.05}}) {
    const auto packed = must(turntable(**context, through_file(plain, packing), UpAxis::y))->views;
    for (std::size_t i = 0; i < 8; ++i) {
      const double off = difference(views[i], packed[i]).mean;
      RecordProperty(fmt::format("packing-{}-view-{}", int(packing), i), fmt::format("{:.3f}", off));
      EXPECT_LE(off, most) << "view " << i << ", packing " << int(packing);
    }
  }
}

TEST(Look, AFoldersShareIsTold) {
  const auto folder = test_folder("share");
  fs::create_directories(folder / "below");
  fs::copy_file(source_folder() / "fixtures/temple.glb", folder / "below/temple.GLB",
                fs::copy_options::overwrite_existing);
  ASSERT_TRUE(write_text_file(folder / "tile.b3dm", "b3dm and more"));
  const auto told = ended(2, run_kasumi("look " + folder.string()));
  EXPECT_THAT(told.out, AllOf(HasSubstr("temple.GLB: 8124 triangles"), HasSubstr("3d-tiles-tools b3dmToGlb"),
                              HasSubstr("1 of 2 models can be read (50 %)")));
  const auto several =
      ended(2, run_kasumi(fmt::format("look {} {}/fixtures/temple.glb", folder.string(), source_folder().string())));
  EXPECT_THAT(several.out, HasSubstr("2 of 3 models can be read (67 %)"));
  EXPECT_THAT(ended(2, run_kasumi("look " + folder.string() + " --out none.png")).err, HasSubstr("are for one model"));
}

TEST(Look, WhatIsNoModelIsRefusedByNameWithWhatConvertsIt) {
  const auto folder = test_folder("others");
  fs::create_directories(folder);
  const auto answer = [&](const std::string& name, const std::string& text) {
    EXPECT_TRUE(write_text_file(folder / name, text));
    const auto told = run_kasumi("look " + (folder / name).string());
    EXPECT_EQ(told.code, 2) << name;
    return told.err;
  };
  EXPECT_THAT(answer("a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float f_dc_0\n"),
              HasSubstr("Gaussian splats"));
  EXPECT_THAT(answer("b.ply", "ply\nformat ascii 1.0\nelement vertex 1\n"), HasSubstr("a point cloud"));
  EXPECT_THAT(answer("a.pnts", "pnts..."), HasSubstr("a point cloud"));
  EXPECT_THAT(answer("b.b3dm", "b3dm..."), HasSubstr("npx 3d-tiles-tools b3dmToGlb -i IN.b3dm -o OUT.glb"));
  // i3dmToGlb would leave the copies out.
  EXPECT_THAT(answer("c.i3dm", "i3dm..."), HasSubstr("npx 3d-tiles-tools convertI3dmToGlb -i IN.i3dm -o OUT.glb"));
  EXPECT_THAT(answer("d.cmpt", "cmpt..."), HasSubstr("npx 3d-tiles-tools splitCmpt -i IN.cmpt -o OUT"));
  EXPECT_THAT(answer("c.las", "LASF..."), HasSubstr("a point cloud"));
  EXPECT_THAT(answer("d.obj", "v 0 0 0\n"), HasSubstr("assimp export IN.obj OUT.glb"));
  EXPECT_THAT(answer("e.usdz", "PK.."), HasSubstr("a scene of USD"));
  EXPECT_THAT(answer("tileset.json", R"({"asset":{"version":"1.0"},"geometricError":1})"), HasSubstr("a tileset"));
  EXPECT_THAT(answer("city.json", R"({"type":"CityJSON"})"), HasSubstr("a model of a city"));
  EXPECT_THAT(answer("f.blend", "BLENDER-v293"), HasSubstr("Blender's own document"));
  EXPECT_THAT(answer("g.gltf", R"({"asset":{"version":"1.1"}})"), HasSubstr("npx gltf-pipeline"));
  EXPECT_THAT(answer("h.glb", ""), HasSubstr("an empty file"));
  EXPECT_THAT(answer("i.glb", "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\n"),
              HasSubstr("git lfs pull"));
  EXPECT_THAT(answer("j.glb", "<!DOCTYPE html><html>404</html>"), HasSubstr("a web page"));
  EXPECT_THAT(answer("e.glb", "text"), HasSubstr("neither a GLB nor the JSON of a glTF"));
}

// Whatever reads a model says on the terminal what is left out of it.
TEST(ModelNotes, ReachEveryTerminal) {
  const std::string note = "KHR_lights_punctual is left out: lamps do not shine";
  const auto folder = content_folder("notes");
  const auto config = write_desk(folder / "desk");
  const auto model = folder / "desk/temple.glb";
  ASSERT_TRUE(fs::exists(model));
  edit_glb(model, [](nlohmann::json& json) {
    json["extensionsUsed"].push_back("KHR_lights_punctual");
    json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}}};
  });
  const auto recording = test_folder("notes-recording");
  fs::remove_all(recording);
  fs::copy(bench_fixture(), recording, fs::copy_options::recursive);
  fs::copy_file(model, recording / "temple.glb", fs::copy_options::overwrite_existing);
  for (const auto& command :
       {"look " + model.string(), "replay " + recording.string() + " --frames 1",
        "run --check --config " + config.string(),
        fmt::format("content pack {} --out {}/n.kasumi --name n", config.string(), folder.string()),
        fmt::format("doctor --config {} --content {}/none", config.string(), folder.string())}) {
    const auto told = run_kasumi(command);
    EXPECT_THAT(told.out + told.err, HasSubstr(note)) << command;
  }
}

}  // namespace
}  // namespace kasumi
