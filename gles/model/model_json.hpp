// Checks a glTF's JSON before it is passed to tinygltf, which trusts it.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"

namespace kasumi {

// The JSON text of a .glb or .gltf. Errors (bad_input): a container with inconsistent lengths, glTF 1 containers.
Result<std::string_view> gltf_json(std::span<const std::uint8_t> file, std::string_view name);

// What the JSON says of itself.
struct GltfClaims {
  std::vector<std::string> extensions;  // used or required, sorted
  std::vector<std::string> notes;       // what is missing without those that are not read
  bool to_mend = false;  // has what tinygltf would refuse, though compressed files have it: mended_json()
};

// Checks size, nesting depth, syntax, asset.version 2.x, and that required extensions are supported. Errors (bad_input):
// as many as possible at once.
Result<GltfClaims> check_gltf_json(std::string_view json, std::string_view name, std::size_t most_values);

// The same without that: buffers that bring no bytes (room for what meshopt packed) get one, and primitives lose
// indices that stand only in Draco's stream; data are named as tinygltf knows them.
std::string mended_json(std::string_view json);

}  // namespace kasumi
