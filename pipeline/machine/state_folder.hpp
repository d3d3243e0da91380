// Whether what is to be remembered over a restart can be.
#pragma once

#include <filesystem>
#include <string>

#include "base/result.hpp"

namespace kasumi {

// Writes to the folder and removes it again. Returns a remark for a person, or nothing. Errors: bad_input (there is no
// such folder, its owner may not write it), io (a disk that is full, read-only, broken or hangs).
Result<std::string> try_state_folder(const std::filesystem::path& folder);

}  // namespace kasumi
