// Tables of numbers as text with a line of names on top, separated by commas, or, as that line is, by semicolons or
// tabs, when numbers may have a decimal comma; every problem is reported with file, line and column.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"

namespace kasumi {

class CsvTable {
 public:
  // Names and cells lose the blanks around them; empty lines are left out. Problems: the file cannot be read, a name is
  // missing or there twice, a row has more or fewer cells than there are names (that row is left out).
  static CsvTable read(const std::filesystem::path& file, Problems& problems);

  const std::vector<std::string>& names() const { return names_; }
  std::optional<std::size_t> column(std::string_view name) const;
  std::size_t rows() const { return lines_.size(); }
  // The row's line in the file, from 1.
  int line(std::size_t row) const { return lines_[row]; }
  const std::string& text(std::size_t row, std::size_t column) const { return cells_[row][column]; }
  // A number from `least` to `most`; else a problem, and nothing.
  std::optional<double> number(std::size_t row, std::size_t column, double least, double most,
                               Problems& problems) const;

 private:
  std::filesystem::path file_;
  char separator_ = ',';
  std::vector<std::string> names_;
  std::vector<int> lines_;
  std::vector<std::vector<std::string>> cells_;  // [row][column]
};

}  // namespace kasumi
