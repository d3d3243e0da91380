// What is kept for months on flash memory, which wears, and through power cuts.
#pragma once

#include <filesystem>
#include <string_view>

#include "base/result.hpp"

namespace kasumi {

// Writes only what the file does not hold already. false: it held the text. Error: io.
Result<bool> update_text_file(const std::filesystem::path& path, std::string_view text);

// Makes the folder and those above it; on return their names are on the disk. Error: io.
Result<> create_folders(const std::filesystem::path& folder);

}  // namespace kasumi
