// What is known of real pictures: comma-separated values, by the first column, then by the names in the heading.
#pragma once

#include <filesystem>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "base/files.hpp"

namespace kasumi {

using TruthTable = std::map<std::string, std::map<std::string, std::string>>;

inline TruthTable read_truth_table(const std::filesystem::path& file) {
  TruthTable table;
  std::istringstream lines(read_text_file(file).value());
  const auto cells_of = [](const std::string& line) {
    std::vector<std::string> cells;
    std::istringstream from(line);
    for (std::string cell; std::getline(from, cell, ',');) cells.push_back(cell);
    return cells;
  };
  std::string line;
  std::getline(lines, line);
  const auto names = cells_of(line);
  while (std::getline(lines, line)) {
    const auto cells = cells_of(line);
    for (std::size_t i = 0; i < cells.size(); ++i) table[cells[0]][names[i]] = cells[i];
  }
  return table;
}

}  // namespace kasumi
