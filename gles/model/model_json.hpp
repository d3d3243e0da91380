// Checks a glTF's JSON before it is passed to tinygltf, which trusts it.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "base/result.hpp"

namespace kasumi {

// The JSON text of a .glb or .gltf. Errors (bad_input): a container with inconsistent lengths, glTF 1 containers.
Result<std::string_view> gltf_json(std::span<const std::uint8_t> file, std::string_view name);

// Checks nesting depth, syntax, asset.version 2.x, and that required extensions are supported. Errors (bad_input): as
// many as possible at once.
Result<> check_gltf_json(std::string_view json, std::string_view name);

}  // namespace kasumi
