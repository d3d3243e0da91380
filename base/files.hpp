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

// A file may come from any account, or be left half written. A pipe or a device under a file's name would block its
// reader for ever, so both are refused.
struct ReadBounds {
  std::size_t most_bytes = std::size_t{1} << 30;  // larger than any file of Kasumi's
  bool or_pipe = false;                           // what a person names on the command line: <(gpg -d key)
};
constexpr ReadBounds kSmallFile{.most_bytes = 1'000'000};  // messages between programs, and files written by hand

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
