// A file under way: it is written under a hidden name beside its own, goes through to the disk and is then renamed, so
// that a power cut at any moment leaves the old or the new file, whole.
#pragma once

#include <filesystem>

#include "base/result.hpp"

namespace kasumi {

// The hidden name, ".STEM.RANDOM.PID.part.EXT", which no other account can guess. The first file in a folder removes
// files of such names there that killed processes or a power cut left.
std::filesystem::path unfinished_name(const std::filesystem::path& path);

// Gives it its own name. On return the file is on the disk under that name, and stays there whatever happens. Error
// (io): the old file, if any, is as it was, and nothing else is left.
Result<> finish_file(const std::filesystem::path& unfinished, const std::filesystem::path& path);

// The names in a folder are on the disk on return. Error: io.
Result<> write_through_names(const std::filesystem::path& folder);

}  // namespace kasumi
