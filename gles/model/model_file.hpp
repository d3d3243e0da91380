// A glTF file and its companions parsed by tinygltf, nothing of it interpreted yet. For this room's glTF sources only.
#pragma once

#include <filesystem>

#include <tiny_gltf.h>

#include "base/result.hpp"
#include "gles/model/model.hpp"

namespace kasumi {

// Pictures stay as they are in their files (Image::as_is); one that is missing or elsewhere is empty.
// Errors: io, bad_input.
Result<tinygltf::Model> parse_gltf(const std::filesystem::path& path, const ModelLimits& limits,
                                   std::vector<std::string>& notes);

}  // namespace kasumi
