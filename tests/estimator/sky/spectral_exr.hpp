// Reads OpenEXR pictures of any channels, as far as reference pictures need: rows of 32-bit numbers, compressed by
// zip or not. (OpenCV reads R, G and B alone.)
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "base/image.hpp"

namespace kasumi::test {

// Channels by name. Throws std::runtime_error on what it does not read.
std::map<std::string, Image<float>> read_exr(const std::filesystem::path& file);

}  // namespace kasumi::test
