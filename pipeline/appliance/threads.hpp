// The appliance as a process: a thread for each loop, signals, an end within two seconds.
#pragma once

#include <filesystem>

#include "pipeline/appliance/status_loop.hpp"

namespace kasumi {

// Runs until SIGTERM, SIGINT or the window is closed; SIGHUP reads configuration and content anew. Call it before any
// other thread exists: the signals are blocked in all of them. Errors: none of the world's faults end it.
Result<> run_appliance(const std::filesystem::path& config_file, ContentPtr content, StatusOptions status);

}  // namespace kasumi
