// Where a mesh's vertices stand: nodes, skins in the pose of their joints, morph targets by their default weights
// (glTF 2.0, 3.5 and 3.7.3). For this room's glTF sources only.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include <tiny_gltf.h>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>

#include "base/result.hpp"
#include "gles/model/accessor.hpp"
#include "gles/model/model.hpp"

namespace kasumi {

// Errors (bad_input, beginning with `what`): not finite, a rotation of no length.
Result<glm::dmat4> transform_of(const tinygltf::Node& node, const std::string& what);

// Moves vertices. A normal turns by the inverse transpose, a mirrored tangent changes its sign.
class VertexTransform {
 public:
  explicit VertexTransform(const glm::dmat4& transform);
  bool mirrors() const { return mirrors_; }
  // False: beyond 10 000 km of the origin, where a float no longer resolves metres, or not finite.
  bool apply(ModelVertex& vertex) const;

 private:
  glm::dmat4 transform_;
  glm::dmat3 turn_, normal_turn_;
  bool mirrors_;
};

// Adds a primitive's morph targets, weighted. Errors (bad_input): accessors as in accessor.hpp.
Result<> morph(Accessors& accessors, const tinygltf::Primitive& primitive, const std::vector<double>& weights,
               ModelPart& part, const ModelLimits& limits, const std::string& what);

// A file's skins. Each is worked out once, and so is each node's place, however many meshes and joints share them.
class Skins {
 public:
  Skins(const tinygltf::Model& gltf, Accessors& accessors, const ModelLimits& limits)
      : gltf_(gltf), accessors_(accessors), limits_(limits) {}

  // A skin's joints, as they move its vertices: their place in the scene times the inverse bind matrices. Errors
  // (bad_input): no such skin or joint, joints that are their own ancestors, matrices of another number.
  Result<const std::vector<glm::dmat4>*> joints(int skin, const std::string& what);

 private:
  void find_parents();
  Result<glm::dmat4> place_of(int node, const std::string& what);

  const tinygltf::Model& gltf_;
  Accessors& accessors_;
  const ModelLimits& limits_;
  std::vector<int> parents_;                       // of each node; -1: none
  std::vector<std::optional<glm::dmat4>> places_;  // of each node in the scene, as far as they were needed
  std::map<int, std::vector<glm::dmat4>> known_;   // by skin
};

// Moves each vertex by its joints (JOINTS_n, WEIGHTS_n), and turns triangles that are mirrored thereby. Errors
// (bad_input): accessors, joints that are not there, places as of VertexTransform.
Result<> pose(Accessors& accessors, const tinygltf::Primitive& primitive, const std::vector<glm::dmat4>& joints,
              ModelPart& part, const ModelLimits& limits, const std::string& what);
// All vertices alike.
Result<> place(ModelPart& part, const glm::dmat4& transform, const std::string& what);

// A node's copies (EXT_mesh_gpu_instancing), relative to it: one of no change where it has none. Errors (bad_input):
// accessors; numbers of elements that differ; more than limits.nodes.
Result<std::vector<glm::dmat4>> instances_of(Accessors& accessors, const tinygltf::Node& node,
                                             const ModelLimits& limits, const std::string& what);

}  // namespace kasumi
