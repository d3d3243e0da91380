// Draco's encoder, in a library of its own: Draco's brings another tinygltf along, which must not come before ours.
#pragma once

#include <cstdint>
#include <vector>

namespace kasumi {

// A mesh of vertices with normals and texture coordinates; indices: three per triangle.
struct PlainMesh {
  std::vector<float> positions, normals, texture;
  std::vector<std::uint32_t> indices;
  std::size_t vertices() const { return positions.size() / 3; }
};

// Draco's stream, in which positions are attribute 0, normals 1 and texture coordinates 2; bits: of a position's
// component. Empty: it cannot be encoded.
std::vector<std::uint8_t> draco_stream(const PlainMesh& mesh, int bits);
// Triangles of so many vertices, and so many constant attributes of four numbers, each of a few bytes.
std::vector<std::uint8_t> constant_draco_stream(std::uint32_t vertices, int attributes);

}  // namespace kasumi
