#include "gles/gpu_model/triangle_chunks.hpp"

#include <algorithm>
#include <functional>
#include <span>
#include <tuple>
#include <utility>

namespace kasumi {
namespace {

struct CutTriangle {
  std::uint32_t part = 0;
  std::uint32_t first_index = 0;
  glm::vec3 centre{};
};
using CutTriangles = std::span<CutTriangle>;

// Splits in space, across the longest axis.
std::pair<CutTriangles, CutTriangles> halves_of(CutTriangles triangles) {
  glm::vec3 lowest = triangles.front().centre, highest = lowest;
  for (const CutTriangle& triangle : triangles) {
    lowest = glm::min(lowest, triangle.centre);
    highest = glm::max(highest, triangle.centre);
  }
  const glm::vec3 extent = highest - lowest;
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const auto middle = triangles.begin() + static_cast<std::ptrdiff_t>(triangles.size() / 2);
  std::ranges::nth_element(triangles, middle, {}, [axis](const CutTriangle& triangle) {
    return std::tuple(triangle.centre[axis], triangle.part, triangle.first_index);
  });
  return {{triangles.begin(), middle}, {middle, triangles.end()}};
}

// Parts with the same material are merged, because files have hundreds of parts and each draw call costs time. The
// result is split in space, so that a tile of the picture draws only nearby chunks.
std::vector<TriangleChunk> cut_parts(const Model& model, const std::vector<ModelPart>& parts) {
  const bool all = &parts == &model.ground;  // the ground is never see-through
  std::vector<std::vector<CutTriangle>> by_material(model.materials.size());
  std::vector<std::uint32_t> first_vertex;  // of each part, if all parts were concatenated
  std::size_t vertices = 0;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    const ModelPart& part = parts[p];
    first_vertex.push_back(static_cast<std::uint32_t>(vertices));
    vertices += part.vertices.size();
    const auto material = static_cast<std::size_t>(part.material);
    if (!all && model.materials[material].alpha == ModelMaterial::Alpha::blend) continue;
    for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3) {
      const auto at = [&](std::size_t j) { return part.vertices[part.indices[i + j]].position; };
      by_material[material].push_back(
          {static_cast<std::uint32_t>(p), static_cast<std::uint32_t>(i), (at(0) + at(1) + at(2)) / 3.0f});
    }
  }
  std::vector<TriangleChunk> chunks;
  ChunkCutter cutter(vertices);
  const std::function<void(int, CutTriangles)> add_split = [&](int material, CutTriangles triangles) {
    if (triangles.empty()) return;
    if (triangles.size() > kMaxChunkTriangles) {
      const auto [first, second] = halves_of(triangles);
      add_split(material, first);
      add_split(material, second);
      return;
    }
    TriangleChunk chunk{material, {}, {}};
    for (const CutTriangle& triangle : triangles) {
      const ModelPart& part = parts[triangle.part];
      for (std::uint32_t j = 0; j < 3; ++j) {
        const std::uint32_t index = part.indices[triangle.first_index + j];
        if (cutter.add(first_vertex[triangle.part] + index)) chunk.vertices.emplace_back(part.vertices[index]);
      }
    }
    chunk.indices = cutter.take();
    chunks.push_back(std::move(chunk));
  };
  for (std::size_t material = 0; material < by_material.size(); ++material) {
    add_split(static_cast<int>(material), by_material[material]);
    by_material[material] = {};
  }
  return chunks;
}

}  // namespace

bool ChunkCutter::add(std::uint32_t vertex) {
  const bool is_new = places_[vertex] == kNone;
  if (is_new) {
    places_[vertex] = static_cast<std::uint16_t>(met_.size());
    met_.push_back(vertex);
  }
  indices_.push_back(places_[vertex]);
  return is_new;
}

std::vector<std::uint16_t> ChunkCutter::take() {
  for (const std::uint32_t vertex : met_) places_[vertex] = kNone;
  met_.clear();
  return std::exchange(indices_, {});
}

TriangleChunks cut_model(const Model& model) {
  return {cut_parts(model, model.parts), cut_parts(model, model.ground)};
}

}  // namespace kasumi
