#include "pipeline/machine/kernel_files.hpp"

#include <algorithm>
#include <cstdlib>
#include <fstream>

namespace kasumi {

std::string line_of(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  return line;
}

std::optional<double> number_of(const std::filesystem::path& file) {
  const auto line = line_of(file);
  char* end = nullptr;
  const double value = std::strtod(line.c_str(), &end);
  if (end == line.c_str()) return std::nullopt;
  return value;
}

std::vector<std::filesystem::path> entries_of(const std::filesystem::path& folder, std::string_view prefix) {
  std::vector<std::filesystem::path> found;
  std::error_code error;
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
    if (entry->path().filename().string().starts_with(prefix)) found.push_back(entry->path());
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace kasumi
