// What is read from a glTF file.
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "base/files.hpp"
#include "gles/model/model.hpp"
#include "tests/gles/model/gltf_writer.hpp"
#include "tests/must.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

// Corners of all triangles in order, so that sharing of vertices does not matter.
std::vector<glm::vec3> corners(const Model& model) {
  std::vector<glm::vec3> all;
  for (const ModelPart& part : model.parts)
    for (const std::uint32_t index : part.indices) all.push_back(part.vertices[index].position);
  return all;
}

std::vector<std::uint8_t> png(int width, int height, const cv::Scalar& bgra) {
  std::vector<std::uint8_t> file;
  cv::imencode(".png", cv::Mat(height, width, CV_8UC4, bgra), file);
  return file;
}

TEST(GltfModel, FacesWithoutNormalsAreFlat) {
  const Model model = loaded(square_file().read("flat"));
  ASSERT_EQ(model.triangle_count(), 2u);
  for (const ModelVertex& vertex : model.parts[0].vertices) EXPECT_EQ(vertex.normal, glm::vec3(0, 0, 1));
  EXPECT_EQ(model.bounds().lowest, glm::vec3(0, 0, 0));
  EXPECT_EQ(model.bounds().highest, glm::vec3(1, 1, 0));
}

TEST(GltfModel, NodesMarkedAsGroundAreNotDrawn) {
  // The object, and three squares of ground: by name, by extras, and by the parent's extras.
  GltfFile file = square_file();
  file.json["materials"] = {{{"pbrMetallicRoughness", {{"baseColorFactor", {0.05, 0.08, 0.03, 1.0}}}}}};
  file.json["meshes"].push_back(file.json["meshes"][0]);
  file.json["meshes"][1]["primitives"][0]["material"] = 0;
  file.json["nodes"] = {{{"mesh", 0}, {"name", "temple"}},
                        {{"mesh", 1}, {"name", "kasumi_ground.001"}, {"translation", {10, 0, 0}}},
                        {{"mesh", 0}, {"extras", {{"kasumi", "ground"}}}, {"children", {3}}},
                        {{"mesh", 0}, {"translation", {0, -5, 0}}},
                        {{"mesh", 0}, {"extras", {{"kasumi", "roof"}}}}};
  file.json["scenes"][0]["nodes"] = {0, 1, 2, 4};
  const Model model = loaded(file.read("ground"));
  EXPECT_EQ(model.triangle_count(), 4u);
  EXPECT_EQ(model.bounds().highest, glm::vec3(1, 1, 0));
  EXPECT_EQ(model.bounds_with_ground().lowest, glm::vec3(0, -5, 0));
  EXPECT_EQ(model.bounds_with_ground().highest, glm::vec3(11, 1, 0));
  ASSERT_EQ(model.ground.size(), 3u);
  int grassy = 0, plain = 0;
  for (const ModelPart& part : model.ground) {
    const auto& colour = model.materials[static_cast<std::size_t>(part.material)].base_colour;
    grassy += std::abs(colour.g - 0.08f) < 1e-6f ? 1 : 0;
    plain += colour == glm::vec4(0.1f, 0.1f, 0.1f, 1.0f) ? 1 : 0;  // no ground has the white of glTF's default
  }
  EXPECT_EQ(grassy, 1);
  EXPECT_EQ(plain, 2);
}

TEST(GltfModel, AModelOfGroundAloneIsRefused) {
  GltfFile file = square_file();
  file.node()["name"] = "kasumi_ground";
  EXPECT_THAT(file.read("only_ground"), FailsWith(HasSubstr("no triangles")));
}

TEST(GltfModel, AllPrimitiveLayoutsGiveTheSameTriangles) {
  const auto expected = corners(loaded(square_file().read("list")));
  GltfFile bytes = square_file();
  bytes.primitive()["indices"] = bytes.add_bytes({0, 1, 2, 0, 2, 3});
  EXPECT_EQ(corners(loaded(bytes.read("bytes"))), expected);
  GltfFile words = square_file();
  words.primitive()["indices"] = words.add_words({0, 1, 2, 0, 2, 3});
  EXPECT_EQ(corners(loaded(words.read("words"))), expected);
  GltfFile none;
  none.primitive()["attributes"]["POSITION"] =
      none.add_floats({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 0, 0, 1, 1, 0, 0, 1, 0}, 3);
  EXPECT_EQ(corners(loaded(none.read("none"))), expected);
  GltfFile fan = square_file();
  fan.primitive()["mode"] = 6;
  fan.primitive()["indices"] = fan.add_shorts({0, 1, 2, 3});
  EXPECT_EQ(corners(loaded(fan.read("fan"))), expected);
  // A strip zigzags; each of its triangles has to face +z.
  GltfFile strip = square_file();
  strip.primitive()["mode"] = 5;
  strip.primitive()["indices"] = strip.add_shorts({0, 1, 3, 2, 2});
  const Model stripped = loaded(strip.read("strip"));
  EXPECT_EQ(stripped.triangle_count(), 2u);
  for (const ModelVertex& vertex : stripped.parts[0].vertices) EXPECT_EQ(vertex.normal, glm::vec3(0, 0, 1));
  const auto glb = model_folder() / "square.glb";
  ASSERT_TRUE(write_file(glb, square_file().binary()));
  EXPECT_EQ(corners(loaded(read_gltf(glb))), expected);
}

TEST(GltfModel, NodesRotateScaleAndTranslateTheirChildren) {
  GltfFile file = square_file();
  // Child: scaled by 2, rotated by 90 degrees about y (x goes to -z), translated by (10, 0, 0); parent: a matrix that
  // translates by (0, 5, 0).
  file.json["nodes"] = {{{"children", {1}}, {"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 5, 0, 1}}},
                        {{"mesh", 0},
                         {"scale", {2, 2, 2}},
                         {"rotation", {0, std::sqrt(0.5), 0, std::sqrt(0.5)}},
                         {"translation", {10, 0, 0}}}};
  const Model model = loaded(file.read("nodes"));
  const auto all = corners(model);
  ASSERT_EQ(all.size(), 6u);
  const std::vector<glm::vec3> expected{{10, 5, 0}, {10, 5, -2}, {10, 7, -2}};
  for (std::size_t i = 0; i < 3; ++i)
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(all[i][c], expected[i][c], 1e-6);
  EXPECT_NEAR(model.parts[0].vertices[0].normal.x, 1.0, 1e-6);
}

TEST(GltfModel, MirroredNodesKeepTheirFrontFaces) {
  GltfFile file = square_file();
  file.primitive()["attributes"]["NORMAL"] = file.add_floats({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, 3);
  file.node()["scale"] = {-1, 1, 1};
  const Model model = loaded(file.read("mirror"));
  const auto all = corners(model);
  ASSERT_EQ(all.size(), 6u);
  EXPECT_GT(glm::cross(all[1] - all[0], all[2] - all[0]).z, 0.0f);
  EXPECT_EQ(model.parts[0].vertices[0].normal, glm::vec3(0, 0, 1));
}

TEST(GltfModel, NonUniformScalingTransformsNormalsCorrectly) {
  GltfFile file = square_file();
  const float d = std::sqrt(0.5f);
  file.primitive()["attributes"]["NORMAL"] = file.add_floats({d, 0, d, d, 0, d, d, 0, d, d, 0, d}, 3);
  file.node()["scale"] = {4, 1, 1};  // a slope along x becomes flatter: its normal turns towards z
  const glm::vec3 normal = loaded(file.read("uneven")).parts.at(0).vertices.at(0).normal;
  EXPECT_NEAR(normal.x / normal.z, 0.25, 1e-6);
}

TEST(GltfModel, InvalidNormalsAreReplacedByFaceNormals) {
  GltfFile file = square_file();
  file.primitive()["attributes"]["NORMAL"] = file.add_floats({0, 0, 0, 0, 0, NAN, 0, 1, 0, 0, 3, 0}, 3);
  const Model model = loaded(file.read("broken-normals"));
  EXPECT_EQ(model.parts[0].vertices[0].normal, glm::vec3(0, 0, 1));
  EXPECT_EQ(model.parts[0].vertices[1].normal, glm::vec3(0, 0, 1));
  EXPECT_EQ(model.parts[0].vertices[3].normal, glm::vec3(0, 1, 0));
  ASSERT_EQ(model.notes.size(), 1u);
  EXPECT_THAT(model.notes[0], HasSubstr("2 invalid normals"));
}

TEST(GltfModel, SparseAccessorsReplaceElements) {
  GltfFile file = square_file();
  const int indices = file.add_shorts({2});
  const int values = file.add_floats({7, 8, 9}, 3);
  file.json["accessors"][0]["sparse"] = {
      {"count", 1},
      {"indices", {{"bufferView", file.json["accessors"][indices]["bufferView"]}, {"componentType", 5123}}},
      {"values", {{"bufferView", file.json["accessors"][values]["bufferView"]}}}};
  const auto all = corners(loaded(file.read("sparse")));
  EXPECT_EQ(all.at(2), glm::vec3(7, 8, 9));
  EXPECT_EQ(all.at(1), glm::vec3(1, 0, 0));
}

TEST(GltfModel, SparseIndicesReplaceIndices) {
  GltfFile file = square_file();
  auto& accessors = file.json["accessors"];
  const auto view = [&](int accessor) { return accessors[static_cast<std::size_t>(accessor)]["bufferView"]; };
  const int first = file.add_shorts({0, 3, 2, 0, 2, 2}), places = file.add_bytes({1, 5});
  const int values = file.add_shorts({1, 3});
  auto& indices = accessors[static_cast<std::size_t>(first)];
  indices["sparse"] = {{"count", 2},
                       {"indices", {{"bufferView", view(places)}, {"componentType", 5121}}},
                       {"values", {{"bufferView", view(values)}}}};
  file.primitive()["indices"] = first;
  EXPECT_EQ(corners(loaded(file.read("sparse-indices"))), corners(loaded(square_file().read("list"))));
  indices["sparse"]["count"] = 7;
  EXPECT_THAT(file.read("sparse-indices").error().message, HasSubstr("7 sparse entries for 6 elements"));
}

TEST(GltfModel, MaterialsAndTheirTexturesAreRead) {
  GltfFile file = square_file();
  file.add_picture(png(3, 2, {30, 20, 10, 128}));
  file.json["samplers"] = {{{"wrapS", 33071}, {"wrapT", 33648}, {"magFilter", 9728}}};
  file.json["textures"][0]["sampler"] = 0;
  file.json["materials"] = {
      {{"name", "leaf"},
       {"alphaMode", "MASK"},
       {"alphaCutoff", 0.25},
       {"doubleSided", true},
       {"extensions", {{"KHR_materials_unlit", nlohmann::json::object()}}},
       {"pbrMetallicRoughness",
        {{"baseColorFactor", {0.5, 0.25, 1.0, 0.75}},
         {"baseColorTexture",
          {{"index", 0},
           {"texCoord", 1},
           {"extensions",
            {{"KHR_texture_transform", {{"offset", {0.5, 0.0}}, {"scale", {2.0, 4.0}}, {"rotation", kPi / 2}}}}}}}}}}};
  file.json["extensionsRequired"] = {"KHR_texture_transform", "KHR_materials_unlit"};
  file.primitive()["material"] = 0;
  file.primitive()["attributes"]["TEXCOORD_0"] = file.add_floats({9, 9, 9, 9, 9, 9, 9, 9}, 2);
  const std::vector<std::uint16_t> normalized{0, 0, 65535, 0, 65535, 65535, 0, 65535};
  file.primitive()["attributes"]["TEXCOORD_1"] = file.add(normalized.data(), 16, 5123, "VEC2", 4);
  file.json["accessors"].back()["normalized"] = true;
  const std::vector<std::uint8_t> colours{255, 0, 51, 255, 0, 51, 255, 0, 51, 255, 0, 51};
  file.primitive()["attributes"]["COLOR_0"] = file.add(colours.data(), 12, 5121, "VEC3", 4);
  file.json["accessors"].back()["normalized"] = true;

  const Model model = loaded(file.read("materials"));
  const ModelMaterial& material = model.materials.at(0);
  EXPECT_EQ(material.name, "leaf");
  EXPECT_EQ(material.base_colour, glm::vec4(0.5f, 0.25f, 1.0f, 0.75f));
  EXPECT_EQ(material.alpha, ModelMaterial::Alpha::mask);
  EXPECT_EQ(material.alpha_cutoff, 0.25f);
  EXPECT_TRUE(material.double_sided);
  ASSERT_EQ(material.texture, 0);
  const ModelTexture& texture = model.textures.at(0);
  EXPECT_EQ(texture.pixels.width(), 3);
  EXPECT_EQ(texture.pixels.height(), 2);
  EXPECT_EQ(texture.pixels.at(2, 1), glm::u8vec4(10, 20, 30, 128));
  EXPECT_EQ(texture.wrap_s, TextureWrap::clamp);
  EXPECT_EQ(texture.wrap_t, TextureWrap::mirrored_repeat);
  EXPECT_TRUE(texture.nearest);
  // Scaled by (2, 4), rotated by a quarter turn as the extension's matrix does ((u, v) to (v, -u)), translated by 0.5
  // in u.
  const ModelVertex& far_corner = model.parts.at(0).vertices.at(model.parts[0].indices.at(2));
  EXPECT_NEAR(far_corner.texture.x, 4.5, 1e-6);
  EXPECT_NEAR(far_corner.texture.y, -2.0, 1e-6);
  EXPECT_EQ(far_corner.colour, glm::vec4(1.0f, 0.0f, 0.2f, 1.0f));
}

TEST(GltfModel, OlderMaterialsUseTheirDiffuseColour) {
  GltfFile file = square_file();
  file.json["materials"] = {
      {{"extensions", {{"KHR_materials_pbrSpecularGlossiness", {{"diffuseFactor", {0.1, 0.2, 0.3, 1.0}}}}}}}};
  file.primitive()["material"] = 0;
  EXPECT_EQ(loaded(file.read("glossiness")).materials.at(0).base_colour, glm::vec4(0.1f, 0.2f, 0.3f, 1.0f));
}

TEST(GltfModel, ReferencedFilesMustLieInTheModelsFolder) {
  GltfFile file = square_file();
  const auto folder = model_folder() / "tree";
  std::filesystem::create_directories(folder / "parts");
  ASSERT_TRUE(write_file(folder / "parts" / "a b.bin", file.buffer));
  ASSERT_TRUE(write_file(model_folder() / "outside.bin", file.buffer));
  std::filesystem::remove(folder / "link.bin");
  std::filesystem::create_symlink(model_folder() / "outside.bin", folder / "link.bin");
  const auto with = [&](const std::string& uri) {
    nlohmann::json json = file.json;
    json["buffers"] = nlohmann::json::array({{{"byteLength", file.buffer.size()}, {"uri", uri}}});
    EXPECT_TRUE(write_text_file(folder / "model.gltf", json.dump()));
    return read_gltf(folder / "model.gltf");
  };
  EXPECT_EQ(loaded(with("parts/a%20b.bin")).triangle_count(), 2u);
  const std::string outside = (model_folder() / "outside.bin").string();
  for (const auto& [uri, why] : std::map<std::string, std::string>{{"../outside.bin", "lies outside"},
                                                                   {outside, "is missing"},
                                                                   {"link.bin", "lies outside"},
                                                                   {"http://example.org/a.bin", "lies elsewhere"},
                                                                   {"file:///etc/passwd", "lies elsewhere"},
                                                                   {"missing.bin", "is missing"}}) {
    const auto refused = with(uri);
    ASSERT_FALSE(refused) << uri;
    EXPECT_THAT(refused.error().message,
                testing::AllOf(HasSubstr("model.gltf: "), HasSubstr(uri + ", which it needs, " + why)));
  }
}

TEST(GltfModel, FilesAreFoundAsWindowsFindsThem) {
  GltfFile file = square_file();
  const auto folder = model_folder() / "windows";
  std::filesystem::create_directories(folder / "Parts");
  ASSERT_TRUE(write_file(folder / "Parts" / "Square.bin", file.buffer));
  for (const std::string uri : {"Parts\\Square.bin", "parts/SQUARE.BIN", ".\\parts\\square.bin"}) {
    nlohmann::json json = file.json;
    json["buffers"] = nlohmann::json::array({{{"byteLength", file.buffer.size()}, {"uri", uri}}});
    ASSERT_TRUE(write_text_file(folder / "model.gltf", json.dump()));
    const Model model = loaded(read_gltf(folder / "model.gltf"));
    EXPECT_EQ(model.triangle_count(), 2u);
    EXPECT_THAT(model.notes, testing::ElementsAre(HasSubstr("Parts/Square.bin: read instead of ")));
    EXPECT_THAT(model.files, testing::Contains(folder / "Parts" / "Square.bin"));
  }
}

TEST(GltfModel, FilesAreFoundByNameWhereTheMachineThatMadeTheModelHadThemElsewhere) {
  GltfFile file = square_file();
  const auto folder = model_folder() / "moved";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder / "textures");
  ASSERT_TRUE(write_file(folder / "textures" / "Square.bin", file.buffer));
  const auto with = [&](const std::string& uri) {
    nlohmann::json json = file.json;
    json["buffers"] = nlohmann::json::array({{{"byteLength", file.buffer.size()}, {"uri", uri}}});
    EXPECT_TRUE(write_text_file(folder / "model.gltf", json.dump()));
    return read_gltf(folder / "model.gltf");
  };
  for (const std::string uri : {"C:\\Users\\me\\square.bin", "..\\maps\\square.bin", "/home/me/Square.bin",
                                "../maps/SQUARE.BIN", "http://example.org/square.bin"}) {
    const Model model = loaded(with(uri));
    EXPECT_EQ(model.triangle_count(), 2u) << uri;
    EXPECT_THAT(model.notes, testing::ElementsAre(HasSubstr("textures/Square.bin: read instead of " + uri)));
  }
  std::filesystem::create_directories(folder / "other");
  ASSERT_TRUE(write_file(folder / "other" / "square.bin", file.buffer));
  EXPECT_FALSE(with("C:\\Users\\me\\square.bin")) << "either may be meant";
}

TEST(GltfModel, ExtensionsThatAreListedAndNotUsedAreNoLoss) {
  GltfFile file = square_file();
  file.json["extensionsUsed"] = {"KHR_materials_volume", "FB_ngon_encoding", "NOBODY_knows"};
  EXPECT_THAT(loaded(file.read("listed")).notes, testing::IsEmpty());
  file.primitive()["extensions"]["FB_ngon_encoding"] = nlohmann::json::object();
  EXPECT_THAT(loaded(file.read("ngons")).notes, testing::IsEmpty());
  file.primitive()["extensions"]["NOBODY_knows"] = nlohmann::json::object();
  EXPECT_THAT(loaded(file.read("unknown")).notes, testing::ElementsAre(HasSubstr("NOBODY_knows is left out")));
}

TEST(GltfModel, TheCastleLoadsCompletely) {
  const std::filesystem::path path = shared_data_folder() / "gltf" / "castle.glb";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
  const Model model = loaded(read_gltf(path));
  EXPECT_GE(model.triangle_count(), 25505u);  // as its README counts; meshes used twice count twice here
  EXPECT_EQ(model.materials.size(), 11u);     // and the default
  for (const ModelPart& part : model.parts)
    for (const ModelVertex& vertex : part.vertices) ASSERT_NEAR(glm::length(vertex.normal), 1.0f, 1e-5);
}

}  // namespace
}  // namespace kasumi
