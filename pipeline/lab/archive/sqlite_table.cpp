#include "pipeline/lab/archive/sqlite_table.hpp"

#include <array>
#include <string>
#include <vector>

#include <sqlite3.h>
#include <nlohmann/json.hpp>

#include "base/c_ptr.hpp"
#include "base/outside/json_text.hpp"
#include "pipeline/lab/archive/estimate_csv.hpp"

namespace kasumi {
namespace {

using Database = CPtr<sqlite3, sqlite3_close>;
using Statement = CPtr<sqlite3_stmt, sqlite3_finalize>;

constexpr std::array kMoreColumns{CsvColumn{"verdict", "/verdict", "TEXT"}, CsvColumn{"refused", "/refused", "TEXT"},
                                  CsvColumn{"sigma_angstrom", "/sigma_angstrom", "REAL"},
                                  CsvColumn{"aerosol", "/aerosol", "TEXT"}};

class SqliteTable final : public RecordTable {
 public:
  explicit SqliteTable(std::filesystem::path path) : path_(std::move(path)) {
    for (const auto& column : estimate_columns())
      columns_.push_back({column, nlohmann::json::json_pointer(column.pointer)});
    for (const auto& column : kMoreColumns) columns_.push_back({column, nlohmann::json::json_pointer(column.pointer)});
  }

  Result<> open() {
    sqlite3* opened = nullptr;
    const int code = sqlite3_open_v2(path_.c_str(), &opened, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, nullptr);
    database_.reset(opened);
    if (code != SQLITE_OK) return failed();
    std::string names = "picture INTEGER PRIMARY KEY", places = "?";
    for (const auto& [column, _] : columns_) {
      names += fmt::format(", {} {}", column.name, column.type);
      places += ", ?";
    }
    // The file is renamed when it is whole: neither journal nor early writing through.
    if (auto made =
            run("PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF; CREATE TABLE pictures (" + names + "); BEGIN");
        !made)
      return made;
    sqlite3_stmt* insert = nullptr;
    if (sqlite3_prepare_v2(database_.get(), ("INSERT INTO pictures VALUES (" + places + ")").c_str(), -1, &insert,
                           nullptr) != SQLITE_OK)
      return failed();
    insert_.reset(insert);
    return {};
  }

  Result<> add(std::string_view, const nlohmann::json& record) override {
    sqlite3_reset(insert_.get());
    bind(1, record["archive"]["picture"]);
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      const auto& place = columns_[i].pointer;
      bind(static_cast<int>(i) + 2, record.contains(place) ? record[place] : nlohmann::json());
    }
    return sqlite3_step(insert_.get()) == SQLITE_DONE ? Result<>() : failed();
  }

  Result<> finish() override {
    insert_.reset();
    return run(
        "CREATE INDEX pictures_by_utc ON pictures (utc); CREATE INDEX pictures_by_verdict ON pictures (verdict); "
        "COMMIT");
  }

 private:
  struct Column {
    CsvColumn column;
    nlohmann::json::json_pointer pointer;
  };
  void bind(int at, const nlohmann::json& value) {
    auto* insert = insert_.get();
    if (value.is_boolean())
      sqlite3_bind_int(insert, at, value.get<bool>() ? 1 : 0);
    else if (value.is_number_integer())
      sqlite3_bind_int64(insert, at, value.get<std::int64_t>());
    else if (value.is_number())
      sqlite3_bind_double(insert, at, value.get<double>());
    else if (value.is_null())
      sqlite3_bind_null(insert, at);
    else {
      const auto text = value.is_string() ? value.get<std::string>() : text_of_json(value);
      sqlite3_bind_text(insert, at, text.data(), static_cast<int>(text.size()), SQLITE_TRANSIENT);
    }
  }
  Result<> run(const std::string& sql) {
    return sqlite3_exec(database_.get(), sql.c_str(), nullptr, nullptr, nullptr) == SQLITE_OK ? Result<>() : failed();
  }
  tl::unexpected<Fault> failed() const {
    return fail(FaultKind::io, "{}: cannot be written: {}", path_.string(), sqlite3_errmsg(database_.get()));
  }

  std::filesystem::path path_;
  std::vector<Column> columns_;
  Database database_;
  Statement insert_;
};

}  // namespace

Result<std::unique_ptr<RecordTable>> open_sqlite_table(const std::filesystem::path& path) {
  auto table = std::make_unique<SqliteTable>(path);
  if (auto opened = table->open(); !opened) return fail(opened.error());
  return table;
}

}  // namespace kasumi
