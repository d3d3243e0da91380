// A curator's desk and a kiosk's shelf on the bench: real content, keys of minisign's.
#pragma once

#include "pipeline/kiosk/content/install.hpp"
#include "pipeline/kiosk/content/packing.hpp"
#include "tests/pipeline/kiosk/appliance/rig.hpp"
#include "tests/pipeline/kiosk/content/bundles.hpp"

namespace kasumi {

inline constexpr Utc kMonday = std::chrono::sys_days{std::chrono::June / 1 / 2026};

// The bench's configuration, such as may be packed: what it remembers lies elsewhere.
inline std::filesystem::path write_desk(const std::filesystem::path& folder, const std::string& edit = {}) {
  const auto config = write_config(folder);
  replace_in(config, "folder = \"state\"", "folder = \"" + (folder.parent_path() / "state").string() + "\"");
  std::filesystem::create_directories(folder.parent_path() / "state");
  EXPECT_TRUE(write_text_file(config, read_text_file(config).value() + edit));
  return config;
}

// A bundle of that desk, not signed.
inline std::filesystem::path packed(const std::filesystem::path& config, const std::string& name, Utc created) {
  const auto out = config.parent_path().parent_path() / (name + kBundleExtension);
  const auto done = pack({config, out, name, created, std::nullopt, {}});
  EXPECT_TRUE(done) << done.error().message;
  return out;
}

inline const InstallRules kUnsigned{.keys = "/no such folder", .unsigned_too = true};

inline Result<Installed> install_file(const std::filesystem::path& bundle, const Generations& generations, Utc now,
                                      InstallRules rules = kUnsigned) {
  auto trusted = open_trusted(bundle, rules);
  if (!trusted) return fail(trusted.error());
  return install(*trusted, generations, rules, now);
}

}  // namespace kasumi
