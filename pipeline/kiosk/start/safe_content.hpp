// The little that safe mode shows. Whatever made the appliance fail may lie in a file, on its disk, or in the code that
// reads it; so none of them is touched by the program that draws.
#pragma once

#include <filesystem>
#include <functional>

#include "pipeline/kiosk/start/start_record.hpp"
#include "pipeline/site/config/content.hpp"

namespace kasumi {

// Where the configuration lies; called where everything else is read.
using FindConfiguration = std::function<std::filesystem::path()>;

// Safe: [display], [still], [words] and [snapshot] of the configuration, read by a process of its own. When that crashes,
// hangs for longer than `deadline` or refuses, what it had found until then is used; the rest stays at its default, and
// the log says why. Words are drawn with the system's fonts.
// Plain: words on a plain background, on the first screen that is found; no file is read, no font either.
// Call it while the caller's threads, if any, hold no lock.
ContentPtr read_safe_content(const FindConfiguration& find, StartMode mode,
                             std::chrono::milliseconds deadline = std::chrono::seconds(10));

}  // namespace kasumi
