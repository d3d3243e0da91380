#include "pipeline/site/files/csv_table.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "base/files.hpp"

namespace kasumi {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

// What stands between the names: a comma, or what spreadsheets write where the comma is in the numbers.
char separator_of(std::string_view names) {
  const auto count = [&](char c) { return std::ranges::count(names, c); };
  if (count(';') > count(',')) return ';';
  return count('\t') > count(',') ? '\t' : ',';
}

std::vector<std::string> cells_of(std::string_view line, char separator) {
  std::vector<std::string> cells;
  for (std::size_t from = 0; from <= line.size();) {
    const auto comma = std::min(line.find(separator, from), line.size());
    cells.emplace_back(trimmed(line.substr(from, comma - from)));
    from = comma + 1;
  }
  return cells;
}

// What is shown of a cell that is not what it should be.
std::string shown(const std::string& cell) {
  constexpr std::size_t kMost = 40;
  std::string text = cell.substr(0, kMost);
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7F; }, '?');
  return text + (cell.size() > kMost ? "..." : "");
}

void check_names(const std::string& file, const std::vector<std::string>& names, Problems& problems) {
  std::unordered_map<std::string_view, std::size_t> columns;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i].empty()) {
      problems.add("{}:1: column {} has no name", file, i + 1);
      continue;
    }
    if (const auto [first, is_new] = columns.emplace(names[i], i); !is_new)
      problems.add("{}:1: column {} is '{}' again, as column {} is: expected each once", file, i + 1, shown(names[i]),
                   first->second + 1);
  }
}

}  // namespace

CsvTable CsvTable::read(const std::filesystem::path& file, Problems& problems) {
  CsvTable table;
  table.file_ = file;
  const auto read = read_text_file(file);
  if (!read) {
    problems.add("{}", read.error().message);
    return table;
  }
  std::string_view text = *read;
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  int number = 0;
  for (std::size_t from = 0; from < text.size();) {
    const auto end = std::min(text.find('\n', from), text.size());
    const auto line = trimmed(text.substr(from, end - from));
    from = end + 1;
    ++number;
    if (number == 1) {
      table.separator_ = separator_of(line);
      table.names_ = cells_of(line, table.separator_);
      check_names(file.string(), table.names_, problems);
      continue;
    }
    if (line.empty()) continue;
    auto cells = cells_of(line, table.separator_);
    if (cells.size() == table.names_.size()) {
      table.lines_.push_back(number);
      table.cells_.push_back(std::move(cells));
    } else {
      problems.add("{}:{}: {} cells, the last in column {}: expected {}, as line 1 has names", file.string(), number,
                   cells.size(), cells.size(), table.names_.size());
    }
  }
  if (number == 0) problems.add("{}: is empty: expected a line of names and a line for each row", file.string());
  return table;
}

std::optional<std::size_t> CsvTable::column(std::string_view name) const {
  const auto found = std::find(names_.begin(), names_.end(), name);
  return found == names_.end() ? std::nullopt : std::optional(static_cast<std::size_t>(found - names_.begin()));
}

std::optional<double> CsvTable::number(std::size_t row, std::size_t column, double least, double most,
                                       Problems& problems) const {
  std::string cell = cells_[row][column];
  if (separator_ != ',' && std::ranges::count(cell, ',') == 1 && cell.find('.') == std::string::npos)
    cell[cell.find(',')] = '.';
  double value = std::numeric_limits<double>::quiet_NaN();
  const char* const from = cell.data() + (cell.starts_with('+') ? 1 : 0);
  const auto [end, error] = std::from_chars(from, cell.data() + cell.size(), value);
  const bool whole = error == std::errc() && end == cell.data() + cell.size() && !cell.empty();
  if (whole && value >= least && value <= most) return value;
  problems.add("{}:{}: column {} ({}): '{}': expected a number from {:g} to {:g}", file_.string(), line(row),
               column + 1, names_[column], shown(cell), least, most);
  return std::nullopt;
}

}  // namespace kasumi
