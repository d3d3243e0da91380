// How much memory this process may still take.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

namespace kasumi {

// Bytes: what the machine has available, or less where the service's control group is bounded (MemoryMax=). Empty: not
// known.
std::optional<std::uint64_t> memory_left(const std::filesystem::path& proc = "/proc",
                                         const std::filesystem::path& cgroups = "/sys/fs/cgroup");

}  // namespace kasumi
