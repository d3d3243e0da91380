// Small files of the kernel: sysfs, procfs.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kasumi {

// First line of the file; empty when it cannot be read.
std::string line_of(const std::filesystem::path& file);
std::optional<double> number_of(const std::filesystem::path& file);
// The folder's entries whose names start with `prefix`, sorted.
std::vector<std::filesystem::path> entries_of(const std::filesystem::path& folder, std::string_view prefix);

}  // namespace kasumi
