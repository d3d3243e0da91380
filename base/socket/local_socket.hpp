// A Unix socket between two programs of one machine, with a deadline for everything.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "base/clock.hpp"
#include "base/result.hpp"
#include "base/unique_fd.hpp"

namespace kasumi {

// Listens at `path`, in place of a socket that an earlier process left there; only its account, its group and root may
// connect. Errors: io.
Result<UniqueFd> listen_at(const std::filesystem::path& path);
// The next caller; empty: none came. BLOCKS for at most `longest`.
UniqueFd accept_within(const UniqueFd& listening, Duration longest);
// The same of several, the first before the others; those that are empty have none. BLOCKS likewise.
struct Caller {
  std::size_t at = 0;  // index of the listening socket
  UniqueFd socket;
};
std::optional<Caller> accept_within(std::span<const UniqueFd> listening, Duration longest);

// Errors: disconnected (no listener), timeout (its queue is full), io.
Result<UniqueFd> connect_to(const std::filesystem::path& path);

// Until a line end, which is left out. Errors: timeout, bad_input (longer than `largest`), disconnected.
Result<std::string> read_line_within(const UniqueFd& socket, std::size_t largest, Duration longest);
// Exactly `bytes`. Errors: timeout, disconnected.
Result<std::string> read_bytes_within(const UniqueFd& socket, std::size_t bytes, Duration longest);
// Errors: timeout, disconnected.
Result<> write_within(const UniqueFd& socket, std::string_view bytes, Duration longest);

}  // namespace kasumi
