// The driver keeps compiled shaders on a disk, and reads them in the thread that draws.
#pragma once

#include "base/clock.hpp"

namespace kasumi {

// Reads the folder that MESA_SHADER_CACHE_DIR names, so that the driver finds it in memory. Where the disk does not
// answer, which is logged, the driver is to do without. BLOCKS for `longest` at most. Call it before GL is used.
void warm_shader_cache(Duration longest = std::chrono::seconds(3));

}  // namespace kasumi
