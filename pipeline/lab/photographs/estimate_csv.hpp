// What `kasumi estimate --csv` writes: a table with a line for each picture, of the same answers as --json.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "base/clock.hpp"

namespace kasumi {

// The names of the columns, and a newline.
std::string estimate_csv_header();
// `answer`: a JSON object of --json; what it lacks, or has as null, is an empty cell. `utc`: when the picture was taken.
std::string estimate_csv_line(std::string_view answer, const std::optional<Utc>& utc);
// Of a picture that could not be read.
std::string estimate_csv_line(const std::string& image, const std::optional<Utc>& utc, const std::string& reason);

}  // namespace kasumi
