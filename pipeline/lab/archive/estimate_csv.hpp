// What `kasumi estimate --csv` writes: a table with a line for each picture, of the same answers as --json.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

#include "base/clock.hpp"

namespace kasumi {

struct CsvColumn {
  const char* name;
  const char* pointer;  // into the answer, as RFC 6901
  const char* type;     // SQL's
};
std::span<const CsvColumn> estimate_columns();

// The names of the columns, and a newline.
std::string estimate_csv_header();
// `answer`: a JSON object of --json; what it lacks, or has as null, is an empty cell. `utc`: when the picture was taken.
std::string estimate_csv_line(std::string_view answer, const std::optional<Utc>& utc);
// Of a record of an archive, which has its time.
std::string csv_line_of_record(const nlohmann::json& record);
// Of a picture that could not be read.
std::string estimate_csv_line(const std::string& image, const std::optional<Utc>& utc, const std::string& reason);

}  // namespace kasumi
