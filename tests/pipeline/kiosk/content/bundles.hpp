// Bundles on the bench: keys by minisign itself, and content small enough to be packed by the dozen.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "base/files.hpp"
#include "pipeline/kiosk/content/bundle.hpp"
#include "pipeline/kiosk/content/digest.hpp"
#include "tests/places.hpp"

namespace kasumi {

inline std::filesystem::path content_folder(const std::string& name) {
  const auto folder = test_output_folder() / "pipeline" / ("content-" + name);
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder;
}

inline bool has_minisign() {
  return std::system("minisign -v >/dev/null 2>&1") == 0;
}

inline int shell(const std::string& line) {
  return std::system((line + " >/dev/null 2>&1").c_str());
}

// A key pair in `folder`: NAME.key, and keys/NAME.pub.
inline void make_keys(const std::filesystem::path& folder, const std::string& name) {
  std::filesystem::create_directories(folder / "keys");
  ASSERT_EQ(shell(fmt::format("minisign -G -W -f -p {0}/keys/{1}.pub -s {0}/{1}.key", folder.string(), name)), 0);
}

// Files with these contents, and a manifest of them.
inline Manifest write_files(const std::filesystem::path& folder,
                            const std::vector<std::pair<std::string, std::string>>& files,
                            const std::string& name = "Spring") {
  Manifest manifest{name, std::chrono::sys_days{std::chrono::March / 20 / 2026}, files.front().first, {}};
  for (const auto& [path, text] : files) {
    std::filesystem::create_directories((folder / path).parent_path());
    EXPECT_TRUE(write_text_file(folder / path, text));
    manifest.files.push_back({path, text.size(), sha256_of(text)});
  }
  return manifest;
}

}  // namespace kasumi
