#include "gles/model/pose.hpp"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/matrix.hpp>

#include "gles/model/gltf_values.hpp"

namespace kasumi {
namespace {

constexpr double kFarthest_m = 1e7;  // a float still resolves metres

// Rotation as x, y, z, w.
glm::dmat4 moved_turned_scaled(const glm::dvec3& move, const glm::dquat& turn, const glm::dvec3& scale) {
  glm::dmat4 matrix = glm::mat4_cast(glm::normalize(turn));
  for (int i = 0; i < 3; ++i) matrix[i] *= scale[i];
  matrix[3] = glm::dvec4(move, 1.0);
  return matrix;
}

tl::unexpected<Fault> too_far(const std::string& what, std::size_t vertex) {
  return fail(FaultKind::bad_input, "{}: vertex {}: more than {} m from the model's origin", what, vertex, kFarthest_m);
}

void turn_over(ModelPart& part, std::size_t first) {
  std::swap(part.indices[first + 1], part.indices[first + 2]);
}

Result<AccessorFloats> of_each_vertex(Accessors& accessors, int accessor, int components, std::size_t vertices,
                                      const ModelLimits& limits, const std::string& what) {
  auto floats = accessors.floats(accessor, {components}, limits.vertices, what);
  if (floats && floats->count != vertices)
    return fail(FaultKind::bad_input, "{} has {} elements for {} vertices", what, floats->count, vertices);
  return floats;
}

// Joints and weights of each vertex, one set of four after the other.
struct Bones {
  std::vector<AccessorFloats> joints, weights;
};

Result<Bones> bones_of(Accessors& accessors, const tinygltf::Primitive& primitive, std::size_t vertices,
                       const ModelLimits& limits, const std::string& what) {
  Bones bones;
  constexpr int kMostSets = 8;
  for (int set = 0; set < kMostSets; ++set) {
    const auto joints = primitive.attributes.find(fmt::format("JOINTS_{}", set));
    const auto weights = primitive.attributes.find(fmt::format("WEIGHTS_{}", set));
    if (joints == primitive.attributes.end() || weights == primitive.attributes.end()) break;
    auto which = of_each_vertex(accessors, joints->second, 4, vertices, limits, what + ": " + joints->first);
    if (!which) return fail(which.error());
    auto how_much = of_each_vertex(accessors, weights->second, 4, vertices, limits, what + ": " + weights->first);
    if (!how_much) return fail(how_much.error());
    bones.joints.push_back(std::move(*which));
    bones.weights.push_back(std::move(*how_much));
  }
  return bones;
}

// Weights add up to 1; where all are 0, the first joint has the vertex, as other readers do.
Result<glm::dmat4> blend(const Bones& bones, std::size_t vertex, const std::vector<glm::dmat4>& joints,
                         const std::string& what) {
  glm::dmat4 sum{0.0};
  double total = 0.0;
  for (std::size_t set = 0; set < bones.joints.size(); ++set)
    for (std::size_t i = 0; i < 4; ++i) {
      const double weight = bones.weights[set].values[4 * vertex + i];
      if (!std::isfinite(weight) || weight <= 0.0) continue;
      const float joint = bones.joints[set].values[4 * vertex + i];
      if (!(joint >= 0.0f) || joint >= static_cast<float>(joints.size()))
        return fail(FaultKind::bad_input, "{}: vertex {}: joint {}: there are {}", what, vertex, joint, joints.size());
      sum += weight * joints[static_cast<std::size_t>(joint)];
      total += weight;
    }
  return total > 0.0 ? sum / total : joints.front();
}

}  // namespace

Result<glm::dmat4> transform_of(const tinygltf::Node& node, const std::string& what) {
  for (const auto* numbers : {&node.matrix, &node.translation, &node.rotation, &node.scale})
    if (!std::ranges::all_of(*numbers, [](double v) { return std::isfinite(v); }))
      return fail(FaultKind::bad_input, "{}: its transform is not finite", what);
  if (node.matrix.size() == 16) {
    glm::dmat4 matrix;
    for (int i = 0; i < 16; ++i) matrix[i / 4][i % 4] = node.matrix[static_cast<std::size_t>(i)];
    return matrix;
  }
  glm::dquat turn(1.0, 0.0, 0.0, 0.0);
  if (node.rotation.size() == 4)
    turn = glm::dquat(node.rotation[3], node.rotation[0], node.rotation[1], node.rotation[2]);
  if (glm::length(turn) < 1e-9) return fail(FaultKind::bad_input, "{}: its rotation is (0, 0, 0, 0)", what);
  const auto three = [](const std::vector<double>& v, double otherwise) {
    return v.size() == 3 ? glm::dvec3(v[0], v[1], v[2]) : glm::dvec3(otherwise);
  };
  return moved_turned_scaled(three(node.translation, 0.0), turn, three(node.scale, 1.0));
}

VertexTransform::VertexTransform(const glm::dmat4& transform)
    : transform_(transform),
      turn_(transform),
      // The cofactor matrix is the inverse transpose times the determinant, and also exists for singular transforms.
      normal_turn_(glm::cross(turn_[1], turn_[2]), glm::cross(turn_[2], turn_[0]), glm::cross(turn_[0], turn_[1])),
      mirrors_(glm::determinant(turn_) < 0.0) {}

bool VertexTransform::apply(ModelVertex& vertex) const {
  const glm::dvec3 position(transform_ * glm::dvec4(vertex.position, 1.0));
  if (!(glm::length(position) <= kFarthest_m)) return false;
  vertex.position = glm::vec3(position);
  const glm::dvec3 normal = (mirrors_ ? -1.0 : 1.0) * (normal_turn_ * glm::dvec3(vertex.normal));
  if (const double length = glm::length(normal); length > 0.0) vertex.normal = glm::vec3(normal / length);
  const glm::dvec3 tangent = turn_ * glm::dvec3(vertex.tangent);
  if (const double length = glm::length(tangent); length > 0.0)
    vertex.tangent = glm::vec4(glm::vec3(tangent / length), mirrors_ ? -vertex.tangent.w : vertex.tangent.w);
  return true;
}

Result<> morph(Accessors& accessors, const tinygltf::Primitive& primitive, const std::vector<double>& weights,
               ModelPart& part, const ModelLimits& limits, const std::string& what) {
  for (std::size_t t = 0; t < primitive.targets.size() && t < weights.size(); ++t) {
    if (!std::isfinite(weights[t]) || weights[t] == 0.0) continue;
    const auto weight = static_cast<float>(weights[t]);
    for (const auto& [semantic, accessor] : primitive.targets[t]) {
      if (semantic != "POSITION" && semantic != "NORMAL" && semantic != "TANGENT") continue;
      const auto moved = of_each_vertex(accessors, accessor, 3, part.vertices.size(), limits,
                                        fmt::format("{}: morph target {}: {}", what, t, semantic));
      if (!moved) return fail(moved.error());
      for (std::size_t i = 0; i < part.vertices.size(); ++i) {
        const glm::vec3 by =
            weight * glm::vec3(moved->values[3 * i], moved->values[3 * i + 1], moved->values[3 * i + 2]);
        ModelVertex& vertex = part.vertices[i];
        if (semantic == "POSITION") vertex.position += by;
        if (semantic == "NORMAL") vertex.normal += by;
        if (semantic == "TANGENT") vertex.tangent += glm::vec4(by, 0.0f);
      }
    }
  }
  return {};
}

void Skins::find_parents() {
  places_.resize(gltf_.nodes.size());
  parents_.assign(gltf_.nodes.size(), -1);
  for (std::size_t i = 0; i < gltf_.nodes.size(); ++i)
    for (const int child : gltf_.nodes[i].children)
      if (child >= 0 && static_cast<std::size_t>(child) < parents_.size())
        parents_[static_cast<std::size_t>(child)] = static_cast<int>(i);
}

Result<glm::dmat4> Skins::place_of(int node, const std::string& what) {
  std::vector<int> above;  // itself and its ancestors whose places are not known yet
  glm::dmat4 whole{1.0};
  for (int at = node; at >= 0; at = parents_[static_cast<std::size_t>(at)]) {
    if (const auto& known = places_[static_cast<std::size_t>(at)]) {
      whole = *known;
      break;
    }
    above.push_back(at);
    if (above.size() > parents_.size())
      return fail(FaultKind::bad_input, "{}: node {} is its own ancestor", what, node);
  }
  for (; !above.empty(); above.pop_back()) {
    const auto at = static_cast<std::size_t>(above.back());
    const auto local = transform_of(gltf_.nodes[at], fmt::format("{}: node {}", what, at));
    if (!local) return fail(local.error());
    places_[at] = whole = whole * *local;
  }
  return whole;
}

Result<const std::vector<glm::dmat4>*> Skins::joints(int skin, const std::string& what) {
  if (const auto known = known_.find(skin); known != known_.end()) return &known->second;
  if (skin < 0 || static_cast<std::size_t>(skin) >= gltf_.skins.size())
    return fail(FaultKind::bad_input, "{}: skin {}: there are {}", what, skin, gltf_.skins.size());
  const tinygltf::Skin& from = gltf_.skins[static_cast<std::size_t>(skin)];
  const std::string named = fmt::format("{}: skin {}", what, skin);
  if (from.joints.empty() || from.joints.size() > limits_.nodes)
    return fail(FaultKind::bad_input, "{}: {} joints", named, from.joints.size());
  AccessorFloats inverse;
  if (from.inverseBindMatrices >= 0) {
    auto read = accessors_.floats(from.inverseBindMatrices, {16}, limits_.nodes, named + ": inverse bind matrices");
    if (!read) return fail(read.error());
    inverse = std::move(*read);
    if (inverse.count < from.joints.size())
      return fail(FaultKind::bad_input, "{}: {} inverse bind matrices for {} joints", named, inverse.count,
                  from.joints.size());
  }
  if (parents_.empty()) find_parents();
  std::vector<glm::dmat4> joints;
  for (std::size_t j = 0; j < from.joints.size(); ++j) {
    const int node = from.joints[j];
    if (node < 0 || static_cast<std::size_t>(node) >= gltf_.nodes.size())
      return fail(FaultKind::bad_input, "{}: joint {} is node {}: there are {}", named, j, node, gltf_.nodes.size());
    const auto whole = place_of(node, named);
    if (!whole) return fail(whole.error());
    glm::dmat4 unbind{1.0};
    if (inverse.count > 0)
      for (int i = 0; i < 16; ++i) unbind[i / 4][i % 4] = inverse.values[16 * j + static_cast<std::size_t>(i)];
    joints.push_back(*whole * unbind);
  }
  return &(known_[skin] = std::move(joints));
}

Result<> pose(Accessors& accessors, const tinygltf::Primitive& primitive, const std::vector<glm::dmat4>& joints,
              ModelPart& part, const ModelLimits& limits, const std::string& what) {
  const auto bones = bones_of(accessors, primitive, part.vertices.size(), limits, what);
  if (!bones) return fail(bones.error());
  std::vector<bool> mirrored(part.vertices.size());
  for (std::size_t i = 0; i < part.vertices.size(); ++i) {
    const auto matrix = blend(*bones, i, joints, what);
    if (!matrix) return fail(matrix.error());
    const VertexTransform transform(*matrix);
    if (!transform.apply(part.vertices[i])) return too_far(what, i);
    mirrored[i] = transform.mirrors();
  }
  for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3)
    if (mirrored[part.indices[i]]) turn_over(part, i);
  return {};
}

Result<> place(ModelPart& part, const glm::dmat4& transform, const std::string& what) {
  const VertexTransform moved(transform);
  for (std::size_t i = 0; i < part.vertices.size(); ++i)
    if (!moved.apply(part.vertices[i])) return too_far(what, i);
  if (moved.mirrors())
    for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3) turn_over(part, i);
  return {};
}

Result<std::vector<glm::dmat4>> instances_of(Accessors& accessors, const tinygltf::Node& node,
                                             const ModelLimits& limits, const std::string& what) {
  const auto* instancing = extension_of(node.extensions, "EXT_mesh_gpu_instancing");
  if (instancing == nullptr || !instancing->IsObject() || !instancing->Has("attributes"))
    return std::vector<glm::dmat4>{glm::dmat4(1.0)};
  std::size_t count = 0;
  const auto read = [&](const char* semantic, int components) -> Result<AccessorFloats> {
    const int accessor = whole_number(instancing->Get("attributes"), semantic, -1);
    if (accessor < 0) return AccessorFloats{};
    auto floats =
        accessors.floats(accessor, {components}, limits.nodes, fmt::format("{}: its copies' {}", what, semantic));
    if (floats && count > 0 && floats->count != count)
      return fail(FaultKind::bad_input, "{}: {} for {} of its copies, others for {}", what, semantic, floats->count,
                  count);
    if (floats) count = floats->count;
    return floats;
  };
  const auto moves = read("TRANSLATION", 3);
  if (!moves) return fail(moves.error());
  const auto turns = read("ROTATION", 4);
  if (!turns) return fail(turns.error());
  const auto scales = read("SCALE", 3);
  if (!scales) return fail(scales.error());
  std::vector<glm::dmat4> instances;
  for (std::size_t i = 0; i < count; ++i) {
    const auto three = [i](const AccessorFloats& from, double otherwise) {
      if (from.count == 0) return glm::dvec3(otherwise);
      return glm::dvec3(from.values[3 * i], from.values[3 * i + 1], from.values[3 * i + 2]);
    };
    glm::dquat turn(1.0, 0.0, 0.0, 0.0);
    if (turns->count > 0) {
      const float* q = &turns->values[4 * i];
      turn = glm::dquat(q[3], q[0], q[1], q[2]);
    }
    if (!(glm::length(turn) > 1e-9))
      return fail(FaultKind::bad_input, "{}: copy {}: its rotation is (0, 0, 0, 0)", what, i);
    instances.push_back(moved_turned_scaled(three(*moves, 0.0), turn, three(*scales, 1.0)));
  }
  return instances;
}

}  // namespace kasumi
