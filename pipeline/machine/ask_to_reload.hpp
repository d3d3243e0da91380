// Asks the running appliance to load its configuration and content anew, and waits for the result.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "base/result.hpp"

namespace kasumi {

// $RUNTIME_DIRECTORY/status.json, else the service's.
std::filesystem::path usual_status_file();

// The problems for which the new content is refused, and the old one stays; none: it is shown. BLOCKS for `longest` at
// most. Errors: disconnected (not running, or it ended meanwhile), io (no permission), timeout.
Result<std::vector<std::string>> ask_to_reload(const std::filesystem::path& status_file, Duration longest);

}  // namespace kasumi
