// What a bundle says it holds. The signature is over this text, and through its hashes over every file.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/clock.hpp"
#include "base/result.hpp"

namespace kasumi {

inline constexpr const char* kManifestName = "manifest.json";
inline constexpr const char* kSignatureName = "manifest.json.minisig";

// Content is untrusted: nothing beyond these limits is unpacked.
inline constexpr std::size_t kMostFiles = 1000;
inline constexpr std::size_t kMostNameBytes = 200;
inline constexpr std::size_t kMostKiosks = 100;
inline constexpr std::size_t kMostFolders = 8;  // one in the other
inline constexpr std::uint64_t kMostFileBytes = std::uint64_t{1} << 30;
inline constexpr std::uint64_t kMostBytes = std::uint64_t{2} << 30;  // of all files
inline constexpr std::size_t kMostManifestBytes = 1 << 20;
inline constexpr std::size_t kMostSignatureBytes = 4096;
// Of a bundle as a file, with what a tar has around each.
inline constexpr std::uint64_t kMostTarBytes = kMostBytes + (kMostFiles + 4) * std::uint64_t{4096} + kMostManifestBytes;

struct PackedFile {
  std::string path;  // below the bundle's folder, with '/'
  std::uint64_t bytes = 0;
  std::string sha256;  // 64 hexadecimal digits
  friend bool operator==(const PackedFile&, const PackedFile&) = default;
};

struct Manifest {
  std::string name;           // for people: "Winter"
  Utc created{};              // to the second
  std::string configuration;  // which of the files is the configuration: "kasumi.toml", in no folder
  std::vector<PackedFile> files;
  std::vector<std::string> for_kiosks{};  // by name; empty: for all
  std::uint64_t bytes() const;
};

// Why a file may not have that name; empty: it may. It stays below the folder it is unpacked in, on every file system.
std::string name_problem(std::string_view path);

std::string manifest_text(const Manifest& manifest);
// Errors (bad_input): all problems at once.
Result<Manifest> parse_manifest(std::string_view text);

// By which the content is known, and called on the disk: the first 16 digits of the hash of its manifest.
std::string content_id(std::string_view manifest_text);

}  // namespace kasumi
