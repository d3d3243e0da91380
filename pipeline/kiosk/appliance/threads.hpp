// The appliance as a process: a thread for each loop, signal handling, shutdown within two seconds.
#pragma once

#include <filesystem>

#include "pipeline/kiosk/appliance/status_loop.hpp"

namespace kasumi {

// Runs until SIGTERM, SIGINT or the window is closed; SIGHUP reloads configuration and content. Call it before any
// other thread exists, since it blocks the signals in all of them. Faults of cameras, displays and disks do not end it.
// `starts` records the result of this start, and content that proves itself is kept in `kept_folder` (empty: nowhere)
// or, as a generation, stays the current one. Returns why the content cannot be drawn, where that has ended it; empty:
// it was ended on purpose.
std::string run_appliance(const ContentPlace& place, ContentPtr content, StatusOutputs status, StartLog& starts,
                          const std::filesystem::path& kept_folder);

}  // namespace kasumi
