// Tries whether a folder can be written, as its owner and not as root: another account's folder may hold planted links
// under any name that can be guessed.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "base/clock.hpp"
#include "base/result.hpp"

namespace kasumi {

struct DiskProbe {
  int error = 0;  // errno; 0: written through to the disk
  bool hangs = false;
  double seconds = 0.0;  // until it was on the disk
  std::string account;   // the account that tried
};

// Writes `bytes` under a random, unused name, and removes them. A root's folder is tried as the service's account, if
// there is one. BLOCKS for `longest` at most. Errors (io): no such folder, or no process can be started.
Result<DiskProbe> probe_disk(const std::filesystem::path& folder, std::size_t bytes,
                             Duration longest = std::chrono::seconds(10));

}  // namespace kasumi
