// Pictures of light itself, in floats: EXR, PFM or HDR by the file's name.
#pragma once

#include <filesystem>

#include <glm/vec3.hpp>

#include "base/image.hpp"
#include "base/result.hpp"

namespace kasumi {

bool is_light_file(const std::filesystem::path& file);  // by its ending
// Linear sRGB. Errors: unsupported (this machine's OpenCV writes no EXR; a PFM lies beside instead, as the message
// says), io.
Result<> write_light_file(const std::filesystem::path& file, const Image<glm::vec3>& light);

}  // namespace kasumi
