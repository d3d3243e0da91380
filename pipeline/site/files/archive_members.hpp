// Pictures inside of tar and zip files, read where they are: "sky.tar:2025/06/21/0930.jpg" is such a picture's path.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"

namespace kasumi {

struct ArchiveMember {
  std::filesystem::path archive;
  std::string name;
  std::filesystem::path path() const { return archive.string() + ":" + name; }
};

// By the ending of its name: .tar, .tgz, .zip and the like.
bool is_archive_file(const std::filesystem::path& path);
// Empty: the path is a file's own, or names no archive before a colon.
std::optional<ArchiveMember> archive_member(const std::filesystem::path& path);

constexpr std::size_t kMostMembers = 5'000'000, kMostMemberBytes = 256 << 20;
// The files in it, in its order; links and folders are left out. Errors: bad_input (no archive, damaged, more members
// than that or names longer than a path may be).
Result<std::vector<std::string>> members_of(const std::filesystem::path& archive);

// What the file, or the member of an archive, holds. Any thread may call it; each keeps the archive that it read last
// open, so that members asked for in the archive's order are each reached by one step. Errors: as read_file();
// bad_input (damaged, encrypted, larger than that, or no such member).
Result<std::vector<std::uint8_t>> read_picture_bytes(const std::filesystem::path& path);

}  // namespace kasumi
