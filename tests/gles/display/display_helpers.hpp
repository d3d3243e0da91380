// Shared by the tests of displays.
#pragma once

#include <cstddef>
#include <filesystem>

#include "base/clock.hpp"

namespace kasumi {

inline const Utc kNoon = Utc{} + std::chrono::hours(24 * 365 * 50 + 12);

// Number of file descriptors this process has open.
inline std::size_t open_descriptors() {
  std::size_t count = 0;
  for ([[maybe_unused]] const auto& fd : std::filesystem::directory_iterator("/proc/self/fd")) ++count;
  return count;
}

}  // namespace kasumi
