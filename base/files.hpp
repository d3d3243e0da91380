// Reads and writes whole files. Output goes to a temporary file that is then renamed, so that a power cut leaves either
// the old or the new file, never part of one.
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

// What is read may have been put there by anybody, or be what is left of something. A pipe or a device under a file's
// name would let its reader wait forever, so they are refused.
struct ReadBounds {
  std::size_t most_bytes = std::size_t{1} << 30;  // none of ours is as large
  bool or_pipe = false;                           // what a person names on the command line: <(gpg -d key)
};
constexpr ReadBounds kSmallFile{.most_bytes = 1'000'000};  // what programs tell each other, or a person writes

// BLOCKS for as long as the disk takes, which may be forever: see base/abandonable.hpp.
Result<std::vector<std::uint8_t>> read_file(const std::filesystem::path& path, const ReadBounds& bounds = {});
Result<std::string> read_text_file(const std::filesystem::path& path, const ReadBounds& bounds = {});

Result<> write_file(const std::filesystem::path& path, std::span<const std::uint8_t> bytes);
Result<> write_text_file(const std::filesystem::path& path, std::string_view text);

// For libraries that write to a path: passes `write` a temporary path in the same folder with the same extension, and
// renames it when `write` succeeds.
Result<> replace_file(const std::filesystem::path& path,
                      const std::function<Result<>(const std::filesystem::path&)>& write);

}  // namespace kasumi
