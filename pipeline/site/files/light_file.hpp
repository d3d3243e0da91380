// Floating-point pictures of linear light: EXR, PFM, HDR or TIFF by the file's extension.
#pragma once

#include <filesystem>

#include <glm/vec3.hpp>

#include "base/image.hpp"
#include "base/result.hpp"

namespace kasumi {

bool is_light_file(const std::filesystem::path& file);  // by its ending
// Linear R G B. Errors: bad_input (other extension, no pixels), unsupported (this OpenCV writes no EXR; a PFM is
// written instead, as the message says), io.
Result<> write_light_file(const std::filesystem::path& file, const Image<glm::vec3>& light);

}  // namespace kasumi
