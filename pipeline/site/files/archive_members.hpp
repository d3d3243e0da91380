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

// What the file, or the member of an archive, holds; of a file its first `most` bytes alone, of a member perhaps more.
// Any thread may call it. Of a zip or plain tar each keeps the one that it read last open: members in its order are each
// reached by a step, others of a tar by their place once they were passed. A compressed tar is read once for all
// threads: of what is passed over kMostKept bytes are kept. What was passed before that is read from the start again.
// Errors: as read_file(); bad_input (damaged, encrypted, larger than that, or no such member).
constexpr std::size_t kMostKept = 32 << 20;
Result<std::vector<std::uint8_t>> read_picture_bytes(const std::filesystem::path& path, std::size_t most = SIZE_MAX);

}  // namespace kasumi
