// From a bundle to the generation that is shown next.
#pragma once

#include "base/lasting_file.hpp"
#include "pipeline/kiosk/content/bundle.hpp"
#include "pipeline/kiosk/content/generations.hpp"
#include "pipeline/kiosk/content/signature.hpp"

namespace kasumi {

struct InstallRules {
  std::filesystem::path keys;  // a folder of public keys that are trusted
  bool unsigned_too = false;
  bool again = false;       // what went back before may be tried once more
  bool newer_only = false;  // what is not newer than all that was taken, or went back before, is left alone
  bool clock_trusted = true;
  std::string kiosk{};  // its name; empty: not known
};

// A bundle whose signature is known; empty `by`: it is not signed, which the rules allow.
struct Trusted {
  Bundle bundle;
  Signed signature;
};
// Of a file, or of the bundle in a folder that was made last. Errors: bad_input (not a bundle, not trusted; of a folder
// what is wrong with each, or that it holds none), io.
Result<Trusted> open_trusted(const std::filesystem::path& path, const InstallRules& rules);

// The bundle that was made last, of several files and folders.
struct Newest {
  std::optional<Trusted> bundle;
  std::vector<std::string> refused;  // what is wrong with others
};
// Folders that are missing or hold none are passed over. Errors: io (a folder that cannot be read); those of the keys.
Result<Newest> open_newest(const std::vector<std::filesystem::path>& paths, const InstallRules& rules);

// Bytes of the disk that content leaves to state, status and journal.
inline constexpr std::uint64_t kContentLeavesFree = std::uint64_t{64} << 20;

struct Installed {
  Generation generation;
  std::string left_alone;  // why nothing was changed; empty: it is shown next
};
// Unpacks it beside the others, reads the whole content as a start would, and only then replaces the link. A power cut
// leaves the old content or the new. Errors: bad_input (all problems of the content, it was rolled back before, is for
// other kiosks, or bears a future date), io (also where its files would leave less of the disk free: nothing is written
// then).
Result<Installed> install(const Trusted& trusted, const Generations& generations, const InstallRules& rules, Utc now,
                          const FreeBytes& free_bytes = free_bytes_of);

}  // namespace kasumi
