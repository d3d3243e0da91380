// The little that safe mode shows: read from the configuration without ever refusing it.
#pragma once

#include <filesystem>

#include "pipeline/config/content.hpp"
#include "pipeline/start/start_record.hpp"

namespace kasumi {

// [display], [still] and [words] of the configuration; what cannot be used of them is logged and left at its default.
// `mode` plain: words on a plain background, on the first screen that is found.
ContentPtr read_safe_content(const std::filesystem::path& config_file, StartMode mode);

}  // namespace kasumi
