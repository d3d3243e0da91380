#include "pipeline/lab/archive/record_table.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>

#include "pipeline/lab/archive/estimate_csv.hpp"
#include "pipeline/lab/archive/sqlite_table.hpp"

namespace kasumi {
namespace {

class TextTable final : public RecordTable {
 public:
  TextTable(const std::filesystem::path& path, bool csv)
      : path_(path), file_(path, std::ios::binary | std::ios::trunc), csv_(csv) {
    if (csv_) file_ << estimate_csv_header();
  }
  Result<> add(std::string_view line, const nlohmann::json& record) override {
    if (csv_)
      file_ << csv_line_of_record(record);
    else
      file_ << line << '\n';
    return state();
  }
  Result<> finish() override {
    file_.close();
    return state();
  }
  Result<> state() const {
    if (file_) return {};
    return fail(FaultKind::io, "{}: cannot be written: {}", path_.string(), std::strerror(errno));
  }

 private:
  std::filesystem::path path_;
  std::ofstream file_;
  bool csv_;
};

}  // namespace

Result<> check_table_name(const std::filesystem::path& path) {
  const auto end = path.extension();
  if (end == ".jsonl" || end == ".csv" || end == ".sqlite") return {};
  return fail(FaultKind::bad_input, "--out {}: expected a name that ends in .jsonl, .csv or .sqlite", path.string());
}

Result<std::unique_ptr<RecordTable>> open_record_table(const std::filesystem::path& path) {
  if (auto known = check_table_name(path); !known) return fail(known.error());
  if (path.extension() == ".sqlite") return open_sqlite_table(path);
  auto table = std::make_unique<TextTable>(path, path.extension() == ".csv");
  if (auto state = table->state(); !state) return fail(state.error());
  return table;
}

}  // namespace kasumi
