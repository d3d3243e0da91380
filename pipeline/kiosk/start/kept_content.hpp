// The configuration and content that have proven themselves, kept for a start that finds the current ones refused,
// unreadable, or failing again and again. Copies of all files with
// their hashes, in the service's state folder: two generations, since a disk may damage either.
#pragma once

#include <filesystem>

#include "pipeline/site/config/content.hpp"

namespace kasumi {

// Copies the content's files into `folder`, unless they are there already, and reads them back; then they replace
// those kept before, in one step that a power cut does not split. BLOCKS for as long as the disk takes.
// Errors: bad_input (a file has changed since it was read, or the copies cannot be read), io.
Result<> keep_content(const Content& content, const std::filesystem::path& folder, Utc now);

// What was kept of that configuration, the newest generation that is whole, with `instead` filled: `refused` says what is wrong with the configured content.
// Errors: bad_input (nothing was kept, damaged), io.
Result<ContentPtr> read_kept_content(const std::filesystem::path& config_file, const std::filesystem::path& folder,
                                     std::vector<std::string> refused);

// Whether what is kept are these files, as they are now.
bool is_kept(const Content& content, const std::filesystem::path& folder);

}  // namespace kasumi
