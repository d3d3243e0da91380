// Whole files in and out. Outputs are written beside their name and renamed, so that a cut leaves the old file or the
// new, never half of one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"

namespace kasumi {

Result<std::vector<std::uint8_t>> read_file(const std::filesystem::path& path);
Result<std::string> read_text_file(const std::filesystem::path& path);

Result<> write_file(const std::filesystem::path& path, std::span<const std::uint8_t> bytes);
Result<> write_text_file(const std::filesystem::path& path, std::string_view text);

// For writers that need a name: hands `write` a temporary path beside `path` with the same extension, and renames it
// when `write` succeeds.
Result<> replace_file(const std::filesystem::path& path,
                      const std::function<Result<>(const std::filesystem::path&)>& write);

}  // namespace kasumi
