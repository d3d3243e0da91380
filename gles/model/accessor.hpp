// Reads a glTF's accessors, with every access checked against its buffer. For this room's glTF sources only.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <tiny_gltf.h>

#include "base/result.hpp"

namespace kasumi {

// count * components floats, normalised integers as fractions, sparse entries applied. `what` and the accessor's number
// begin every message. Errors (bad_input): no such accessor, a number of components not in `components`, more elements
// than `limit`, an accessor beyond its buffer view or a view beyond its buffer.
struct AccessorFloats {
  int components = 0;
  std::size_t count = 0;
  std::vector<float> values;
};
Result<AccessorFloats> read_floats(const tinygltf::Model& gltf, int accessor, std::initializer_list<int> components,
                                   std::size_t limit, const std::string& what);

// Unsigned indices of 8, 16 or 32 bits.
Result<std::vector<std::uint32_t>> read_indices(const tinygltf::Model& gltf, int accessor, std::size_t limit,
                                                const std::string& what);

}  // namespace kasumi
