// Parses a glTF file and the files it refers to with tinygltf, without interpreting them. For this room's glTF sources
// only.
#pragma once

#include <filesystem>

#include <tiny_gltf.h>

#include "base/result.hpp"
#include "gles/model/model.hpp"

namespace kasumi {

// `files` gains every file that was read, `extensions` gets those that it uses. Pictures stay encoded (Image::as_is); those missing or outside the folder are empty.
// Errors: io, bad_input.
Result<tinygltf::Model> parse_gltf(const std::filesystem::path& path, const ModelLimits& limits,
                                   std::vector<std::string>& notes, std::vector<std::filesystem::path>& files,
                                   std::vector<std::string>& extensions);

}  // namespace kasumi
