// Records written as one table, one after the other.
#pragma once

#include <filesystem>
#include <memory>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

#include "base/result.hpp"

namespace kasumi {

class RecordTable {
 public:
  virtual ~RecordTable() = default;
  // `line`: the record as its part has it, without newline. Error: io.
  virtual Result<> add(std::string_view line, const nlohmann::json& record) = 0;
  // After the last. Error: io.
  virtual Result<> finish() = 0;
};

// Errors: bad_input (the name ends neither in .jsonl nor .csv nor .sqlite).
Result<> check_table_name(const std::filesystem::path& path);
// By the name's end; replaces what is there. Errors: as check_table_name(), io.
Result<std::unique_ptr<RecordTable>> open_record_table(const std::filesystem::path& path);

}  // namespace kasumi
