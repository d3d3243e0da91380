// The appliance as a process: a thread for each loop, signal handling, shutdown within two seconds.
#pragma once

#include <filesystem>

#include "pipeline/appliance/status_loop.hpp"

namespace kasumi {

// Runs until SIGTERM, SIGINT or the window is closed; SIGHUP reloads configuration and content. Call it before any
// other thread exists, since it blocks the signals in all of them. Faults of cameras, displays and disks do not end it.
Result<> run_appliance(const std::filesystem::path& config_file, ContentPtr content, StatusOptions status);

}  // namespace kasumi
