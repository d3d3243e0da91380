// A glTF's JSON looked over before a parser that trusts it sees it.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "base/result.hpp"

namespace kasumi {

// The JSON text of a .glb or .gltf. Errors (bad_input): a container whose lengths do not add up, glTF 1 containers.
Result<std::string_view> gltf_json(std::span<const std::uint8_t> file, std::string_view name);

// Depth of nesting, syntax, asset.version 2.x, required extensions that we know. Errors (bad_input), all at once where
// that is possible.
Result<> check_gltf_json(std::string_view json, std::string_view name);

}  // namespace kasumi
