// Parts of the program that stand in modules beside it, because few need them and the libraries behind them are large
// or read what strangers made: each is loaded at its first use and kept until the program ends.
#pragma once

#include <string>

#include "base/result.hpp"

namespace kasumi {

// What `entry` of module `file` ("kasumi-rare-files.so") returns; it lies where the program lies, or in ../lib/kasumi as
// installed. ENTRY_version must name `version`, the program's. `purpose` begins every message.
// Errors: unsupported (it is not there, of another version, or a library that it needs is missing).
Result<const void*> loaded_module(const char* file, const std::string& entry, const char* version, const char* purpose);

}  // namespace kasumi
