// The result of the last unattended installation (from a stick, a folder, a server), for the senders:
// CONTENT/arrived.json, which the running appliance shows in its status.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "base/clock.hpp"
#include "base/result.hpp"

namespace kasumi {

struct Arrival {
  Utc utc{};
  std::string from;    // the folders
  std::string words;   // the result
  bool taken = false;  // it is what is shown next
};

// Error: io.
Result<> note_arrival(const std::filesystem::path& content, const Arrival& arrival);
// Empty: nothing has been brought yet.
std::optional<Arrival> last_arrival(const std::filesystem::path& content);

}  // namespace kasumi
