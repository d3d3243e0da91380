// Tries whether a folder can be written, as whoever it belongs to and not as root: in a folder of somebody else's, links
// may have been planted under any name that can be guessed.
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
  std::string account;   // as whom it was tried
};

// Writes `bytes` under a random name that nobody else has, and removes them. A root's folder is tried as the service's
// account, if there is one. BLOCKS for `longest` at most. Errors (io): no such folder, or no process can be started.
Result<DiskProbe> probe_disk(const std::filesystem::path& folder, std::size_t bytes,
                             Duration longest = std::chrono::seconds(10));

}  // namespace kasumi
