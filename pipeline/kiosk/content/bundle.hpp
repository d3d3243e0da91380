// A bundle: a tar of a manifest, its signature, and the files that the manifest names; nothing else is allowed in it.
// It is untrusted: checking it writes nothing, and only a bundle that passed the check is unpacked.
#pragma once

#include <filesystem>
#include <map>

#include "base/unique_fd.hpp"
#include "pipeline/kiosk/content/manifest.hpp"

namespace kasumi {

inline constexpr const char* kBundleExtension = ".kasumi";

struct Bundle {
  UniqueFd file;
  std::filesystem::path path;  // for messages
  std::string manifest_text;   // as it is signed
  Manifest manifest;
  std::string signature;  // of manifest_text; empty: it is not signed
  std::string id() const { return content_id(manifest_text); }
};

// Opens it and reads the names and sizes of all that is in it, the manifest and the signature. Errors: bad_input (all
// problems at once: names that lead out of the folder, links, devices, sizes beyond the bounds, files that the manifest
// does not name or that are missing), io.
Result<Bundle> look_into(const std::filesystem::path& path);

// Compares every file with its hash in the manifest. Errors: bad_input (all problems at once), io.
Result<> check_files(const Bundle& bundle);

// The same, and writes them, the manifest and the signature below `folder`, which must be empty. On return everything
// is on the disk, whatever happens then. Errors: those of check_files(); the folder then holds a part.
Result<> unpack(const Bundle& bundle, const std::filesystem::path& folder);

// Compares what was unpacked with its manifest. Error (bad_input): all files that are missing or damaged.
Result<> check_unpacked(const std::filesystem::path& folder, const Manifest& manifest);

// Writes a bundle of files below `folder`, or of those of `instead`, by the names in the manifest. It is there whole or not
// at all. Errors: bad_input (a file has changed since the manifest was made), io.
Result<> write_bundle(const std::filesystem::path& path, const std::filesystem::path& folder, const Manifest& manifest,
                      std::string_view signature, const std::map<std::string, std::filesystem::path>& instead = {});

}  // namespace kasumi
