// What is read from a glTF file's materials, scenes and compressed data.
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <opencv2/imgcodecs.hpp>

#include "gles/model/model.hpp"
#include "tests/gles/model/gltf_writer.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

// A square with texture coordinates of two sets and a material that the test fills in.
GltfFile surface_file() {
  GltfFile file = square_file();
  file.primitive()["attributes"]["NORMAL"] = file.add_floats({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, 3);
  file.primitive()["attributes"]["TEXCOORD_0"] = file.add_floats({0, 1, 1, 1, 1, 0, 0, 0}, 2);
  file.primitive()["attributes"]["TEXCOORD_1"] = file.add_floats({0, 0, 0, 1, 1, 1, 1, 0}, 2);
  std::vector<std::uint8_t> png;
  cv::imencode(".png", cv::Mat(2, 2, CV_8UC3, cv::Scalar(30, 20, 10)), png);
  file.add_picture(png);
  file.primitive()["material"] = 0;
  file.json["materials"] = {nlohmann::json::object()};
  return file;
}

TEST(GltfMaterial, DefaultsAreThoseOfTheSpecification) {
  const ModelMaterial material = loaded(surface_file().read("defaults")).materials.at(0);
  EXPECT_EQ(material.metallic, 1.0f);
  EXPECT_EQ(material.roughness, 1.0f);
  EXPECT_EQ(material.reflectance, glm::vec3(0.04f));
  EXPECT_EQ(material.edge_reflectance, 1.0f);
  EXPECT_EQ(material.emission, glm::vec3(0.0f));
  EXPECT_FALSE(material.unlit);
  EXPECT_FALSE(material.normal_map.used());
}

TEST(GltfMaterial, EveryPropertyIsRead) {
  GltfFile file = surface_file();
  const nlohmann::json moved = {{"KHR_texture_transform", {{"scale", {2.0, 2.0}}}}};
  file.json["materials"][0] = {
      {"pbrMetallicRoughness",
       {{"metallicFactor", 0.25},
        {"roughnessFactor", 0.75},
        {"baseColorTexture", {{"index", 0}}},
        {"metallicRoughnessTexture", {{"index", 0}}}}},
      {"normalTexture", {{"index", 0}, {"scale", 0.5}}},
      {"occlusionTexture", {{"index", 0}, {"strength", 0.6}, {"texCoord", 1}, {"extensions", moved}}},
      {"emissiveTexture", {{"index", 0}, {"texCoord", 1}, {"extensions", moved}}},
      {"emissiveFactor", {1.0, 0.5, 0.0}},
      {"extensions", {{"KHR_materials_emissive_strength", {{"emissiveStrength", 4.0}}}}}};
  const Model model = loaded(file.read("every"));
  const ModelMaterial& material = model.materials.at(0);
  EXPECT_EQ(material.metallic, 0.25f);
  EXPECT_EQ(material.roughness, 0.75f);
  EXPECT_EQ(material.normal_scale, 0.5f);
  EXPECT_EQ(material.occlusion_strength, 0.6f);
  EXPECT_EQ(material.emission, glm::vec3(4.0f, 2.0f, 0.0f));
  // One picture used as colour and as data: as colour it is decoded from sRGB, as data it is not.
  ASSERT_EQ(model.textures.size(), 2u);
  EXPECT_FALSE(model.textures[static_cast<std::size_t>(material.texture)].data);
  EXPECT_TRUE(model.textures[static_cast<std::size_t>(material.roughness_map.texture)].data);
  EXPECT_EQ(material.normal_map.texture, material.roughness_map.texture);
  EXPECT_EQ(material.emission_map.texture, material.texture);
  EXPECT_FALSE(material.normal_map.second);
  EXPECT_TRUE(material.occlusion_map.second);
  EXPECT_TRUE(material.emission_map.second);
  const ModelVertex& corner = model.parts.at(0).vertices.at(2);
  EXPECT_EQ(corner.texture, glm::vec2(1, 0));
  EXPECT_EQ(corner.texture_2, glm::vec2(2, 2));
}

TEST(GltfMaterial, IndexOfRefractionAndSpecularSetTheReflectance) {
  GltfFile file = surface_file();
  file.json["materials"][0]["extensions"] = {
      {"KHR_materials_ior", {{"ior", 2.0}}},
      {"KHR_materials_specular", {{"specularFactor", 0.5}, {"specularColorFactor", {1.0, 0.5, 20.0}}}}};
  const ModelMaterial material = loaded(file.read("ior")).materials.at(0);
  // ((2 - 1) / (2 + 1))^2 = 1/9, tinted, at most 1, then halved.
  EXPECT_NEAR(material.reflectance.r, 0.5 / 9.0, 1e-6);
  EXPECT_NEAR(material.reflectance.g, 0.25 / 9.0, 1e-6);
  EXPECT_NEAR(material.reflectance.b, 0.5, 1e-6);
  EXPECT_EQ(material.edge_reflectance, 0.5f);
}

// Gold by its specular colour over black, and plaster by its diffuse one: two texels each.
TEST(GltfMaterial, OlderMaterialsBecomeMetalOrNotByTheirSpecularTexture) {
  GltfFile file = surface_file();
  const auto picture = [](const cv::Vec4b& left, const cv::Vec4b& right) {
    cv::Mat texels(1, 2, CV_8UC4);
    texels.at<cv::Vec4b>(0, 0) = left;
    texels.at<cv::Vec4b>(0, 1) = right;
    std::vector<std::uint8_t> png;
    cv::imencode(".png", texels, png);
    return "data:image/png;base64," + base64(png);
  };
  // Blue, green, red, alpha.
  file.json["images"] = {{{"uri", picture({0, 0, 0, 255}, {150, 160, 170, 255})}},
                         {{"uri", picture({90, 200, 250, 204}, {56, 56, 56, 51})}}};
  file.json["textures"] = {{{"source", 0}}, {{"source", 1}}};
  auto& older = file.json["materials"][0]["extensions"]["KHR_materials_pbrSpecularGlossiness"];
  older = {{"diffuseTexture", {{"index", 0}}}, {"specularGlossinessTexture", {{"index", 1}}}};
  const Model model = loaded(file.read("older"));
  const ModelMaterial& material = model.materials.at(0);
  ASSERT_EQ(model.textures.size(), 2u);  // what they are made of is not kept
  const auto& colour = model.textures.at(static_cast<std::size_t>(material.texture)).pixels;
  const auto& rough = model.textures.at(static_cast<std::size_t>(material.roughness_map.texture)).pixels;
  EXPECT_NEAR(colour.at(0, 0).r, 250, 2);
  EXPECT_NEAR(colour.at(0, 0).b, 90, 2);
  EXPECT_NEAR(colour.at(1, 0).r, 170, 2);
  EXPECT_NEAR(colour.at(1, 0).b, 150, 2);
  EXPECT_NEAR(rough.at(0, 0).b, 255, 2);  // metal
  EXPECT_NEAR(rough.at(1, 0).b, 0, 3);
  EXPECT_NEAR(rough.at(0, 0).g, 51, 1);
  EXPECT_NEAR(rough.at(1, 0).g, 204, 1);
  EXPECT_EQ(material.metallic, 1.0f);
  EXPECT_THAT(model.notes, testing::IsEmpty());
  // Pictures that are laid differently are not converted, which is said.
  older["specularGlossinessTexture"]["texCoord"] = 1;
  EXPECT_THAT(loaded(file.read("older")).notes, testing::Contains(HasSubstr("specularGlossinessTexture is left out")));
}

TEST(GltfMaterial, APictureWithoutTextureCoordinatesIsReported) {
  GltfFile file = surface_file();
  file.json["materials"][0] = {{"name", "wall"}, {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}};
  EXPECT_THAT(loaded(file.read("laid")).notes, testing::IsEmpty());
  file.primitive()["attributes"].erase("TEXCOORD_0");
  EXPECT_THAT(loaded(file.read("not-laid")).notes,
              testing::ElementsAre(HasSubstr("material \"wall\": a mesh has no texture coordinates")));
}

TEST(GltfMaterial, UnlitNeedsOnlyItsColour) {
  GltfFile file = surface_file();
  file.json["materials"][0] = {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}},
                               {"normalTexture", {{"index", 0}}},
                               {"extensions", {{"KHR_materials_unlit", nlohmann::json::object()}}}};
  const Model model = loaded(file.read("unlit"));
  EXPECT_TRUE(model.materials.at(0).unlit);
  EXPECT_FALSE(model.materials.at(0).normal_map.used());
  EXPECT_EQ(model.textures.size(), 1u);
}

TEST(GltfMaterial, AThirdTextureTransformIsIgnoredAndReported) {
  GltfFile file = surface_file();
  const auto turned = [](double turn) {
    return nlohmann::json{{"index", 0}, {"extensions", {{"KHR_texture_transform", {{"rotation", turn}}}}}};
  };
  file.json["materials"][0] = {{"pbrMetallicRoughness", {{"baseColorTexture", turned(0.1)}}},
                               {"normalTexture", turned(0.2)},
                               {"occlusionTexture", turned(0.3)}};
  const Model model = loaded(file.read("three-ways"));
  EXPECT_TRUE(model.materials.at(0).normal_map.used());
  EXPECT_FALSE(model.materials.at(0).occlusion_map.used());
  EXPECT_THAT(model.notes, testing::Contains(HasSubstr("its occlusion picture is left out")));
}

TEST(GltfMaterial, TangentsAreReadOrGenerated) {
  GltfFile file = surface_file();
  file.json["materials"][0]["normalTexture"] = {{"index", 0}};
  // Made: texture x grows along x, y downwards; the picture lies upright.
  const Model made = loaded(file.read("tangents"));
  for (const ModelVertex& vertex : made.parts.at(0).vertices) EXPECT_EQ(vertex.tangent, glm::vec4(1, 0, 0, 1));
  // By the second coordinates, x grows along y and y along x: mirrored? (0,0)-(0,1)-(1,1): y to x, x to y.
  file.json["materials"][0]["normalTexture"]["texCoord"] = 1;
  const Model second = loaded(file.read("tangents-2"));
  for (const ModelVertex& vertex : second.parts.at(0).vertices) EXPECT_EQ(vertex.tangent, glm::vec4(0, 1, 0, 1));
  // Given tangents are made perpendicular to their normals.
  file.primitive()["attributes"]["TANGENT"] = file.add_floats({0, 3, 4, -1, 0, 3, 4, -1, 0, 3, 4, -1, 0, 0, 0, 1}, 4);
  const Model given = loaded(file.read("tangents-given"));
  EXPECT_EQ(given.parts.at(0).vertices.at(0).tangent, glm::vec4(0, 1, 0, -1));
  EXPECT_NEAR(glm::length(glm::vec3(given.parts.at(0).vertices.at(3).tangent)), 1.0, 1e-6);  // had none
  // Tangents rotate with their node, and a mirroring node mirrors the picture too.
  file.node()["rotation"] = {0, 0, std::sqrt(0.5), std::sqrt(0.5)};  // x to y
  file.node()["scale"] = {1, 1, -1};
  const glm::vec4 turned = loaded(file.read("tangents-turned")).parts.at(0).vertices.at(0).tangent;
  EXPECT_NEAR(turned.x, -1.0, 1e-6);
  EXPECT_EQ(turned.w, 1.0f);
}

TEST(GltfMaterial, TangentsSplitWhereATextureMeetsItsMirrorImage) {
  GltfFile file = square_file();
  // Two adjacent squares share an edge; the texture on the right one mirrors the left one's.
  file.primitive()["attributes"]["POSITION"] =
      file.add_floats({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 2, 0, 0, 2, 1, 0}, 3);
  file.primitive()["attributes"]["NORMAL"] = file.add_floats({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, 3);
  file.primitive()["attributes"]["TEXCOORD_0"] = file.add_floats({0, 1, 1, 1, 1, 0, 0, 0, 0, 1, 0, 0}, 2);
  file.primitive()["indices"] = file.add_shorts({0, 1, 2, 0, 2, 3, 1, 4, 5, 1, 5, 2});
  std::vector<std::uint8_t> png;
  cv::imencode(".png", cv::Mat(2, 2, CV_8UC3, cv::Scalar(255, 128, 128)), png);
  file.add_picture(png);
  file.primitive()["material"] = 0;
  file.json["materials"] = {{{"normalTexture", {{"index", 0}}}}};
  const Model model = loaded(file.read("seam"));
  const ModelPart& part = model.parts.at(0);
  EXPECT_EQ(part.vertices.size(), 8u);  // the two on the seam twice
  for (std::size_t i = 0; i < part.indices.size(); ++i)
    EXPECT_EQ(part.vertices[part.indices[i]].tangent, i < 6 ? glm::vec4(1, 0, 0, 1) : glm::vec4(-1, 0, 0, -1)) << i;
}

TEST(GltfScenes, ErasAreChosenByNameOrNumber) {
  GltfFile file = square_file();
  file.json["nodes"] = {{{"mesh", 0}}, {{"mesh", 0}, {"translation", {10, 0, 0}}}};
  file.json["scenes"] = {{{"name", "Asuka"}, {"nodes", {0}}}, {{"name", "Nara"}, {"nodes", {0, 1}}}};
  file.json["scene"] = 1;
  EXPECT_EQ(loaded(file.read("eras")).triangle_count(), 4u);
  const auto path = model_folder() / "eras.gltf";
  for (const char* first : {"Asuka", "0"}) EXPECT_EQ(loaded(read_gltf(path, {}, first)).triangle_count(), 2u);
  for (const char* second : {"Nara", "1"}) EXPECT_EQ(loaded(read_gltf(path, {}, second)).triangle_count(), 4u);
  EXPECT_THAT(loaded(read_gltf(path)).scenes, testing::ElementsAre("Asuka", "Nara"));
  for (const char* none : {"Edo", "2", "-1", "1.0", "nara"}) {
    const auto refused = read_gltf(path, {}, none);
    ASSERT_FALSE(refused) << none;
    EXPECT_THAT(refused.error().message,
                testing::AllOf(HasSubstr("eras.gltf"), HasSubstr(none), HasSubstr("0 \"Asuka\", 1 \"Nara\"")));
  }
}

TEST(GltfCompression, IsRefusedByNameWithARemedy) {
  GltfFile file = square_file();
  file.json["extensionsRequired"] = {"EXT_texture_avif", "KHR_texture_basisu", "VENDOR_new_thing"};
  const auto refused = file.read("compressed");
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message,
              testing::AllOf(HasSubstr("compressed.gltf"), HasSubstr("AVIF"), HasSubstr("gltf-transform/cli png"),
                             testing::Not(HasSubstr("KHR_texture_basisu")),
                             HasSubstr("VENDOR_new_thing, which Kasumi does not read: export without it")));
}

TEST(GltfCompression, TexturesAvailableOnlyInAvifAreIgnoredAndReported) {
  GltfFile file = surface_file();
  file.json["textures"][0] = {{"extensions", {{"EXT_texture_avif", {{"source", 0}}}}}};
  file.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = 0;
  const Model model = loaded(file.read("avif"));
  EXPECT_EQ(model.materials.at(0).texture, -1);
  EXPECT_THAT(model.notes, testing::Contains(HasSubstr("EXT_texture_avif")));
}

TEST(GltfSamples, OfTheKhronosGroupKeepTheirMaterials) {
  const std::filesystem::path root = "/usr/share/assimp/models/glTF2";
  if (!std::filesystem::exists(root)) GTEST_SKIP() << "apt install assimp-testmodels";
  const Model coats = loaded(read_gltf(root / "ClearCoat-glTF/ClearCoatTest.gltf"));
  int relief = 0, rough = 0, smooth = 0;
  for (const ModelMaterial& material : coats.materials) {
    relief += material.normal_map.used();
    (material.roughness < 0.5f ? smooth : rough) += material.reflects();
  }
  EXPECT_GT(relief, 0);
  EXPECT_GT(rough, 0);
  EXPECT_GT(smooth, 0);
  for (const ModelPart& part : coats.parts)
    if (coats.materials[static_cast<std::size_t>(part.material)].normal_map.used())
      for (const ModelVertex& vertex : part.vertices) {
        ASSERT_NEAR(glm::length(glm::vec3(vertex.tangent)), 1.0f, 1e-4);
        ASSERT_NEAR(glm::dot(glm::vec3(vertex.tangent), vertex.normal), 0.0f, 1e-4);
      }
  EXPECT_EQ(loaded(read_gltf(root / "draco/2CylinderEngine.gltf")).triangle_count(), 110336u);
  // Six texture transforms on a square, and a seventh for reference.
  EXPECT_GT(loaded(read_gltf(root / "textureTransform/TextureTransformTest.gltf")).parts.size(), 5u);
}

}  // namespace
}  // namespace kasumi
