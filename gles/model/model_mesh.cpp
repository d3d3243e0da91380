#include "gles/model/model_mesh.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/geometric.hpp>

namespace kasumi {
namespace {

constexpr int kFan = 6, kStrip = 5, kList = 4;

glm::vec3 face_normal(const ModelPart& part, std::size_t first_index) {
  const auto at = [&](std::size_t i) { return glm::dvec3(part.vertices[part.indices[first_index + i]].position); };
  const glm::dvec3 normal = glm::cross(at(1) - at(0), at(2) - at(0));
  const double length = glm::length(normal);
  return length > 0.0 ? glm::vec3(normal / length) : glm::vec3(0, 1, 0);
}

// Any direction perpendicular to a unit vector.
glm::dvec3 any_across(const glm::dvec3& n) {
  return glm::normalize(glm::cross(n, std::abs(n.x) < 0.7 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0)));
}

// The direction of growing texture x on a triangle (unit vector; 0 if undefined), and whether the picture is mirrored.
struct TextureOrientation {
  glm::dvec3 along{0.0};
  bool mirrored = false;
};

TextureOrientation texture_orientation(const std::array<const ModelVertex*, 3>& corners, bool second) {
  const auto place = [&](std::size_t i) { return glm::dvec2(second ? corners[i]->texture_2 : corners[i]->texture); };
  const glm::dvec3 p0(corners[0]->position);
  const glm::dvec3 p1 = glm::dvec3(corners[1]->position) - p0, p2 = glm::dvec3(corners[2]->position) - p0;
  const glm::dvec2 t1 = place(1) - place(0), t2 = place(2) - place(0);
  const double area = t1.x * t2.y - t2.x * t1.y;
  if (!std::isfinite(area) || area == 0.0) return {};
  // Texture y grows downwards in the picture, but glTF's bitangent points upwards.
  const glm::dvec3 along = (p1 * t2.y - p2 * t1.y) / area;
  return {glm::length(along) > 0.0 ? glm::normalize(along) : along, area > 0.0};
}

double angle_at(const std::array<const ModelVertex*, 3>& corners, std::size_t corner) {
  const glm::dvec3 here(corners[corner]->position);
  const glm::dvec3 a = glm::dvec3(corners[(corner + 1) % 3]->position) - here;
  const glm::dvec3 b = glm::dvec3(corners[(corner + 2) % 3]->position) - here;
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

}  // namespace

std::vector<std::uint32_t> as_triangles(const std::vector<std::uint32_t>& indices, int mode) {
  std::vector<std::uint32_t> triangles;
  triangles.reserve(mode == kList ? indices.size() : 3 * indices.size());
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    if (a != b && b != c && c != a) triangles.insert(triangles.end(), {a, b, c});
  };
  const std::size_t step = mode == kList ? 3 : 1;
  for (std::size_t i = 0; i + 2 < indices.size(); i += step) {
    if (mode == kFan)
      add(indices[0], indices[i + 1], indices[i + 2]);
    else if (mode == kStrip && i % 2 == 1)
      add(indices[i + 1], indices[i], indices[i + 2]);
    else
      add(indices[i], indices[i + 1], indices[i + 2]);
  }
  return triangles;
}

void give_flat_normals(ModelPart& part) {
  ModelPart flat;
  flat.material = part.material;
  for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3) {
    const glm::vec3 normal = face_normal(part, i);
    for (std::size_t j = 0; j < 3; ++j) {
      flat.indices.push_back(static_cast<std::uint32_t>(flat.vertices.size()));
      flat.vertices.push_back(part.vertices[part.indices[i + j]]);
      flat.vertices.back().normal = normal;
    }
  }
  part = std::move(flat);
}

std::size_t mend_normals(ModelPart& part) {
  std::vector<bool> broken(part.vertices.size());
  for (std::size_t i = 0; i < broken.size(); ++i) {
    const double length = glm::length(glm::dvec3(part.vertices[i].normal));
    broken[i] = !(length > 1e-12 && std::isfinite(length));
    if (!broken[i]) part.vertices[i].normal /= static_cast<float>(length);
  }
  const auto count = static_cast<std::size_t>(std::ranges::count(broken, true));
  for (std::size_t i = 0; count > 0 && i < part.indices.size(); ++i)
    if (const std::uint32_t index = part.indices[i]; broken[index]) {
      part.vertices[index].normal = face_normal(part, i - i % 3);
      broken[index] = false;
    }
  return count;
}

void give_tangents(ModelPart& part, bool second_coordinates) {
  const std::size_t vertices = part.vertices.size();
  std::vector<std::array<glm::dvec3, 2>> sums(vertices, {glm::dvec3(0.0), glm::dvec3(0.0)});  // upright, mirrored
  std::vector<std::array<bool, 2>> used(vertices, {false, false});
  std::vector<bool> mirrored(part.indices.size() / 3);
  for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3) {
    const auto vertex = [&](std::size_t j) { return &part.vertices[part.indices[i + j]]; };
    const std::array<const ModelVertex*, 3> corners{vertex(0), vertex(1), vertex(2)};
    const TextureOrientation orientation = texture_orientation(corners, second_coordinates);
    mirrored[i / 3] = orientation.mirrored;
    for (std::size_t j = 0; j < 3; ++j) {
      const std::uint32_t index = part.indices[i + j];
      sums[index][orientation.mirrored ? 1 : 0] += angle_at(corners, j) * orientation.along;
      used[index][orientation.mirrored ? 1 : 0] = true;
    }
  }
  std::vector<std::uint32_t> twin(vertices);
  for (std::size_t i = 0; i < vertices; ++i) {
    const bool only_mirrored = used[i][1] && !used[i][0];
    part.vertices[i].tangent = glm::vec4(glm::vec3(sums[i][only_mirrored ? 1 : 0]), only_mirrored ? -1.0f : 1.0f);
    twin[i] = static_cast<std::uint32_t>(i);
    if (!used[i][0] || !used[i][1]) continue;
    twin[i] = static_cast<std::uint32_t>(part.vertices.size());
    part.vertices.push_back(part.vertices[i]);
    part.vertices.back().tangent = glm::vec4(glm::vec3(sums[i][1]), -1.0f);
  }
  for (std::size_t i = 0; i < part.indices.size(); ++i)
    if (mirrored[i / 3]) part.indices[i] = twin[part.indices[i]];
  mend_tangents(part);
}

void mend_tangents(ModelPart& part) {
  for (ModelVertex& vertex : part.vertices) {
    const glm::dvec3 n(vertex.normal);
    const glm::dvec3 given(vertex.tangent);
    const glm::dvec3 across = given - n * glm::dot(n, given);
    const double length = glm::length(across);
    const glm::dvec3 along = length > 1e-9 && std::isfinite(length) ? across / length : any_across(n);
    vertex.tangent = glm::vec4(glm::vec3(along), vertex.tangent.w < 0.0f ? -1.0f : 1.0f);
  }
}

}  // namespace kasumi
