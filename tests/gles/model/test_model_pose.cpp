// Where a model's vertices stand: skins, morph targets, copies, what is invisible.
#include <chrono>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "gles/model/model.hpp"
#include "tests/gles/model/gltf_writer.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

// The square of gltf_writer.hpp on a node that is moved by 100, with a joint that is moved by (0, 0, 5) and scales by 2.
GltfFile skinned_square() {
  GltfFile file = square_file();
  file.node()["translation"] = {100, 0, 0};
  file.node()["skin"] = 0;
  file.json["nodes"].push_back({{"translation", {0, 0, 4}}, {"children", {2}}});
  file.json["nodes"].push_back({{"translation", {0, 0, 1}}, {"scale", {2, 2, 2}}});
  file.json["scenes"][0]["nodes"] = {0, 1};
  file.json["skins"] = {{{"joints", {1, 2}}}};
  auto& attributes = file.primitive()["attributes"];
  const std::vector<std::uint8_t> joints{1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
  attributes["JOINTS_0"] = file.add(joints.data(), joints.size(), 5121, "VEC4", 4);
  attributes["WEIGHTS_0"] = file.add_floats({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, 4);
  return file;
}

TEST(ModelPose, ASkinStandsWhereItsJointsAreAndIgnoresItsNode) {
  const Model model = loaded(skinned_square().read("skin"));
  EXPECT_EQ(model.bounds().lowest, glm::vec3(0, 0, 5));
  EXPECT_EQ(model.bounds().highest, glm::vec3(2, 2, 5));
  EXPECT_EQ(model.parts.at(0).vertices.at(0).normal, glm::vec3(0, 0, 1));
}

TEST(ModelPose, InverseBindMatricesComeFirst) {
  GltfFile file = skinned_square();
  const std::vector<float> matrices{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0,  1,   // the first joint's
                                    1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -1, 1};  // moves by (0, 0, -1)
  file.json["skins"][0]["inverseBindMatrices"] = file.add(matrices.data(), 4 * matrices.size(), 5126, "MAT4", 2);
  EXPECT_EQ(loaded(file.read("bind")).bounds().lowest, glm::vec3(0, 0, 3));
}

TEST(ModelPose, WeightsBlendJointsAndNeedNotAddUpToOne) {
  GltfFile file = skinned_square();
  const std::vector<std::uint8_t> joints{0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0};
  file.primitive()["attributes"]["JOINTS_0"] = file.add(joints.data(), joints.size(), 5121, "VEC4", 4);
  file.primitive()["attributes"]["WEIGHTS_0"] = file.add_floats({1, 1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0}, 4);
  const Model model = loaded(file.read("blend"));
  EXPECT_EQ(model.bounds().lowest, glm::vec3(0, 0, 4.5f));
  EXPECT_EQ(model.bounds().highest, glm::vec3(1.5f, 1.5f, 4.5f));
}

TEST(ModelPose, JointsThatMirrorTurnTheTrianglesRound) {
  GltfFile file = skinned_square();
  file.json["nodes"][2]["scale"] = {-2, 2, 2};
  const ModelPart part = loaded(file.read("mirror")).parts.at(0);
  EXPECT_EQ(part.vertices.at(part.indices.at(0)).normal, glm::vec3(0, 0, 1));
}

TEST(ModelPose, FalseSkinsAreRefusedByName) {
  GltfFile beyond = skinned_square();
  beyond.json["skins"][0]["joints"] = {1};
  EXPECT_THAT(beyond.read("skin").error().message, HasSubstr("vertex 0: joint 1: there are 1"));
  GltfFile none = skinned_square();
  none.node()["skin"] = 3;
  EXPECT_THAT(none.read("skin").error().message, HasSubstr("skin 3: there are 1"));
  GltfFile nowhere = skinned_square();
  nowhere.json["skins"][0]["joints"] = {1, 9};
  EXPECT_THAT(nowhere.read("skin").error().message, HasSubstr("joint 1 is node 9"));
  GltfFile ring = skinned_square();
  ring.json["nodes"][2]["children"] = {1};
  ring.json["scenes"][0]["nodes"] = {0};
  EXPECT_THAT(ring.read("skin").error().message, HasSubstr("is its own ancestor"));
}

// Each joint hangs from the one before, and many meshes share the skin: what is read is read once.
TEST(ModelPose, ManyJointsAndManyMeshesOfOneSkinAreReadInLittleTime) {
  constexpr int kJoints = 20'000, kMeshes = 2'000;
  GltfFile file = square_file();
  auto& attributes = file.primitive()["attributes"];
  const std::vector<std::uint16_t> joints{kJoints - 1, 0, 0, 0, kJoints - 1, 0, 0, 0,
                                          kJoints - 1, 0, 0, 0, kJoints - 1, 0, 0, 0};
  attributes["JOINTS_0"] = file.add(joints.data(), 2 * joints.size(), 5123, "VEC4", 4);
  attributes["WEIGHTS_0"] = file.add_floats({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, 4);
  auto nodes = nlohmann::json::array(), list = nlohmann::json::array(), roots = nlohmann::json::array({0});
  for (int i = 0; i < kJoints; ++i) {
    nodes.push_back({{"translation", {0, 0, i % 2 == 0 ? 1 : -1}}});
    if (i + 1 < kJoints) nodes.back()["children"] = {i + 1};
    list.push_back(i);
  }
  for (int i = 0; i < kMeshes; ++i) {
    nodes.push_back({{"mesh", 0}, {"skin", 0}});
    roots.push_back(kJoints + i);
  }
  file.json["nodes"] = nodes;
  file.json["scenes"][0]["nodes"] = roots;
  file.json["skins"] = {{{"joints", list}}};
  const auto began = std::chrono::steady_clock::now();
  const Model model = loaded(file.read("joints"));
  EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds(20));
  EXPECT_EQ(model.triangle_count(), 2u * kMeshes);
  EXPECT_EQ(model.bounds().lowest, glm::vec3(0, 0, 0));
  EXPECT_EQ(model.bounds().highest, glm::vec3(1, 1, 0));
}

// One target that lifts the square by 3, another that doubles it.
GltfFile morphed_square() {
  GltfFile file = square_file();
  const int lift = file.add_floats({0, 0, 3, 0, 0, 3, 0, 0, 3, 0, 0, 3}, 3);
  const int twice = file.add_floats({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, 3);
  file.primitive()["targets"] = {{{"POSITION", lift}}, {{"POSITION", twice}}};
  file.json["meshes"][0]["weights"] = {1, 0.5};
  return file;
}

TEST(ModelPose, MorphTargetsStandByTheirDefaultWeightsANodesBeforeAMeshs) {
  GltfFile file = morphed_square();
  Model model = loaded(file.read("morph"));
  EXPECT_EQ(model.bounds().lowest, glm::vec3(0, 0, 3));
  EXPECT_EQ(model.bounds().highest, glm::vec3(1.5f, 1.5f, 3));
  file.node()["weights"] = {0, 1};
  model = loaded(file.read("morph"));
  EXPECT_EQ(model.bounds().highest, glm::vec3(2, 2, 0));
  file.node().erase("weights");
  file.json["meshes"][0].erase("weights");
  EXPECT_EQ(loaded(file.read("morph")).bounds().highest, glm::vec3(1, 1, 0));
}

TEST(ModelPose, SparseMorphTargetsMoveSomeVertices) {
  GltfFile file = morphed_square();
  const int places = file.add_shorts({2});
  const int values = file.add_floats({0, 0, 8}, 3);
  auto& accessors = file.json["accessors"];
  const auto view = [&](int accessor) { return accessors[static_cast<std::size_t>(accessor)]["bufferView"]; };
  const nlohmann::json sparse{{"count", 1},
                              {"indices", {{"bufferView", view(places)}, {"componentType", 5123}}},
                              {"values", {{"bufferView", view(values)}}}};
  accessors.push_back({{"componentType", 5126}, {"type", "VEC3"}, {"count", 4}, {"sparse", sparse}});
  file.primitive()["targets"] = {{{"POSITION", accessors.size() - 1}}};
  file.json["meshes"][0]["weights"] = {0.5};
  const Model model = loaded(file.read("sparse"));
  EXPECT_EQ(model.bounds().lowest.z, 0.0f);
  EXPECT_EQ(model.bounds().highest, glm::vec3(1, 1, 4));
}

TEST(ModelPose, AMorphTargetOfOtherVerticesIsRefused) {
  GltfFile file = morphed_square();
  file.primitive()["targets"][0]["POSITION"] = file.add_floats({0, 0, 3}, 3);
  EXPECT_THAT(file.read("morph").error().message, HasSubstr("morph target 0: POSITION has 1 elements for 4 vertices"));
}

TEST(ModelPose, CopiesStandWhereTheyAreTold) {
  GltfFile file = square_file();
  file.node()["translation"] = {0, 10, 0};
  nlohmann::json attributes;
  attributes["TRANSLATION"] = file.add_floats({0, 0, 0, 5, 0, 0, 9, 0, 0}, 3);
  attributes["SCALE"] = file.add_floats({1, 1, 1, 2, 2, 2, 1, 1, 1}, 3);
  attributes["ROTATION"] = file.add_floats({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 0}, 4);  // the last by 180 deg about z
  file.node()["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = attributes;
  file.json["extensionsRequired"] = {"EXT_mesh_gpu_instancing"};
  const Model model = loaded(file.read("copies"));
  ASSERT_EQ(model.parts.size(), 3u);
  EXPECT_EQ(model.triangle_count(), 6u);
  EXPECT_EQ(model.parts[1].vertices.at(1).position, glm::vec3(7, 10, 0));
  EXPECT_NEAR(model.parts[2].vertices.at(1).position.x, 8.0f, 1e-6f);
  // They count as what is drawn.
  EXPECT_THAT(file.read("copies", {.triangles = 5}).error().message, HasSubstr("more than 5 triangles"));
  file.node()["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["SCALE"] = file.add_floats({1, 1, 1}, 3);
  EXPECT_THAT(file.read("copies").error().message, HasSubstr("of its copies"));
}

TEST(ModelPose, WhatIsInvisibleIsLeftOutAndThatIsSaid) {
  GltfFile file = square_file();
  file.json["nodes"].push_back({{"children", {2}}, {"extensions", {{"KHR_node_visibility", {{"visible", false}}}}}});
  file.json["nodes"].push_back({{"mesh", 0}, {"translation", {50, 0, 0}}});
  file.json["scenes"][0]["nodes"] = {0, 1};
  const Model model = loaded(file.read("visible"));
  EXPECT_EQ(model.bounds().highest, glm::vec3(1, 1, 0));
  EXPECT_THAT(model.notes, testing::ElementsAre(HasSubstr("invisible")));
}

}  // namespace
}  // namespace kasumi
