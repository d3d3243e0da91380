// Records as one SQLite file: table `pictures`, with the columns of --csv, what sky the estimator saw, and indices by
// time and by that.
#pragma once

#include <filesystem>
#include <memory>

#include "pipeline/lab/archive/record_table.hpp"

namespace kasumi {

// Errors: io.
Result<std::unique_ptr<RecordTable>> open_sqlite_table(const std::filesystem::path& path);

}  // namespace kasumi
