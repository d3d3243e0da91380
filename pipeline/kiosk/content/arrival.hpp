// What came of the bundles that were brought last without anybody at the keyboard (a stick, a folder, a server), for
// those who sent them: CONTENT/arrived.json, which the running appliance tells in its status.
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
  std::string words;   // what came of it
  bool taken = false;  // it is what is shown next
};

// Error: io.
Result<> note_arrival(const std::filesystem::path& content, const Arrival& arrival);
// Empty: nothing has been brought yet.
std::optional<Arrival> last_arrival(const std::filesystem::path& content);

}  // namespace kasumi
