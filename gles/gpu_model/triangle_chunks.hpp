// A model cut into chunks for the GPU, without GL: large models take a second, which need not be the drawing thread's.
#pragma once

#include <cstdint>
#include <vector>

#include "gles/gpu_model/gpu_vertex.hpp"
#include "gles/model/model.hpp"

namespace kasumi {

// Triangles of one material that lie together, few enough for 16-bit indices.
struct TriangleChunk {
  int material = 0;
  std::vector<GpuVertex> vertices;
  std::vector<std::uint16_t> indices;
};
constexpr std::size_t kMaxChunkTriangles = 2048;

struct TriangleChunks {
  std::vector<TriangleChunk> solid, ground;  // without see-through surfaces, whose order depends on the view
};
// The model must be sound: see check(Model).
TriangleChunks cut_model(const Model& model);

// Renumbers the vertices of a chunk's triangles from 0.
class ChunkCutter {
 public:
  explicit ChunkCutter(std::size_t vertices) : places_(vertices, kNone) {}
  // Whether the vertex is new to this chunk.
  bool add(std::uint32_t vertex);
  std::vector<std::uint16_t> take();

 private:
  static constexpr std::uint16_t kNone = 0xFFFF;
  static_assert(3 * kMaxChunkTriangles < kNone);
  std::vector<std::uint16_t> places_;
  std::vector<std::uint32_t> met_;
  std::vector<std::uint16_t> indices_;
};

}  // namespace kasumi
