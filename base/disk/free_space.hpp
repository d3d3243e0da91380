// How much room is left on a disk. Whoever must leave some of it to others takes the function, so that a test can hand in
// a full disk.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>

#include "base/result.hpp"

namespace kasumi {

// Bytes of the folder's disk that are free for those who are not root. Error: io.
using FreeBytes = std::function<Result<std::uint64_t>(const std::filesystem::path& folder)>;
Result<std::uint64_t> free_bytes_of(const std::filesystem::path& folder);

}  // namespace kasumi
