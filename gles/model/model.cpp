#include "gles/model/model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace kasumi {

std::size_t Model::triangle_count() const {
  std::size_t count = 0;
  for (const ModelPart& part : parts) count += part.indices.size() / 3;
  return count;
}

namespace {

ModelBounds united(ModelBounds bounds, const std::vector<ModelPart>& parts) {
  for (const ModelPart& part : parts)
    for (const ModelVertex& vertex : part.vertices) {
      bounds.lowest = glm::min(bounds.lowest, vertex.position);
      bounds.highest = glm::max(bounds.highest, vertex.position);
    }
  return bounds;
}

}  // namespace

ModelBounds Model::bounds() const {
  constexpr float kInfinite = std::numeric_limits<float>::infinity();
  return united({glm::vec3(kInfinite), glm::vec3(-kInfinite)}, parts);
}

ModelBounds Model::bounds_with_ground() const {
  return united(bounds(), ground);
}

namespace {

void check_part(const Model& model, const ModelPart& part, const std::string& what, Problems& problems) {
  if (part.material < 0 || static_cast<std::size_t>(part.material) >= model.materials.size())
    problems.add("model: {}: material {}: there are {}", what, part.material, model.materials.size());
  if (part.indices.size() % 3 != 0)
    problems.add("model: {}: {} indices: expected three per triangle", what, part.indices.size());
  const auto beyond = std::ranges::find_if(part.indices, [&](std::uint32_t i) { return i >= part.vertices.size(); });
  if (beyond != part.indices.end())
    problems.add("model: {}: index {}: there are {} vertices", what, *beyond, part.vertices.size());
  const auto broken = std::ranges::find_if(part.vertices, [](const ModelVertex& v) {
    return !std::isfinite(v.position.x) || !std::isfinite(v.position.y) || !std::isfinite(v.position.z);
  });
  if (broken != part.vertices.end())
    problems.add("model: {}: vertex {}: its position is not finite", what, broken - part.vertices.begin());
}

std::array<int, 5> textures_of(const ModelMaterial& material) {
  return {material.texture, material.normal_map.texture, material.roughness_map.texture, material.occlusion_map.texture,
          material.emission_map.texture};
}

}  // namespace

Result<> check(const Model& model) {
  Problems problems;
  for (std::size_t i = 0; i < model.parts.size(); ++i)
    check_part(model, model.parts[i], fmt::format("part {}", i), problems);
  for (std::size_t i = 0; i < model.ground.size(); ++i)
    check_part(model, model.ground[i], fmt::format("part {} of the ground", i), problems);
  for (std::size_t i = 0; i < model.materials.size(); ++i)
    for (const int texture : textures_of(model.materials[i]))
      if (texture < -1 || texture >= static_cast<int>(model.textures.size()))
        problems.add("model: material {}: texture {}: there are {}", i, texture, model.textures.size());
  for (std::size_t i = 0; i < model.textures.size(); ++i)
    if (model.textures[i].pixels.empty()) problems.add("model: texture {} is empty", i);
  if (model.triangle_count() == 0) problems.add("model {}: no triangles to draw", model.name);
  if (!problems.empty()) return fail(problems.fault());
  return {};
}

glm::dmat4 model_to_world(const Placement& placement) {
  const double c = placement.scale * std::cos(placement.heading.value);
  const double s = placement.scale * std::sin(placement.heading.value);
  // The directions that are east, up and north at heading 0, turned clockwise as seen from above.
  const glm::dvec4 east{c, -s, 0.0, 0.0}, north{s, c, 0.0, 0.0}, up{0.0, 0.0, placement.scale, 0.0};
  const glm::dvec4 place{placement.east_m, placement.north_m, placement.up_m, 1.0};
  if (placement.up_axis == UpAxis::z) return {east, north, up, place};
  return {east, up, -north, place};
}

}  // namespace kasumi
