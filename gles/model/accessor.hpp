// Reads a glTF's accessors, with every access checked against its buffer. For this room's glTF sources only.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <tiny_gltf.h>

#include "base/result.hpp"
#include "gles/model/model.hpp"

namespace kasumi {

struct AccessorFloats {
  int components = 0;
  std::size_t count = 0;
  std::vector<float> values;
};

// `what` and the accessor's number begin every message. Errors (bad_input): no such accessor, more elements than
// `limit`, an accessor beyond its buffer view or a view beyond its buffer, more than ModelLimits::numbers in all.
class Accessors {
 public:
  Accessors(const tinygltf::Model& gltf, const ModelLimits& limits)
      : gltf_(gltf), most_(limits.numbers), left_(limits.numbers) {}

  // count * components floats, normalised integers as fractions, sparse entries applied. Errors: also a number of
  // components not in `components`.
  Result<AccessorFloats> floats(int accessor, std::initializer_list<int> components, std::size_t limit,
                                const std::string& what);
  // Unsigned indices of 8, 16 or 32 bits.
  Result<std::vector<std::uint32_t>> indices(int accessor, std::size_t limit, const std::string& what);

 private:
  Result<const tinygltf::Accessor*> find(int index, std::size_t limit, const std::string& what);

  const tinygltf::Model& gltf_;
  std::size_t most_, left_;
};

}  // namespace kasumi
