// What is kept for months on flash memory, which wears, and through power cuts.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string_view>

#include "base/result.hpp"

namespace kasumi {

// Writes only what the file does not hold already. false: it held the text. Error: io.
Result<bool> update_text_file(const std::filesystem::path& path, std::string_view text);

// Makes the folder and those above it; on return their names are on the disk. Error: io.
Result<> create_folders(const std::filesystem::path& folder);

// Bytes of the folder's disk that are free for those who are not root. Error: io. Code that leaves space to others
// takes this as a parameter, so that a test can simulate a full disk.
using FreeBytes = std::function<Result<std::uint64_t>(const std::filesystem::path& folder)>;
Result<std::uint64_t> free_bytes_of(const std::filesystem::path& folder);

}  // namespace kasumi
