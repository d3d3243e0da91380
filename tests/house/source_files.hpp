// The repository's own code, as the tests in this folder read it.
#pragma once

#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "tests/places.hpp"

namespace kasumi::house {

struct Include {
  std::string target;  // "base/result.hpp"
  bool ours = false;   // in quotes
};

struct SourceFile {
  std::string name;  // from the repository's root
  std::string folder;
  std::vector<Include> includes;
};

inline std::string folder_of(const std::string& name) {
  const auto slash = name.rfind('/');
  return slash == std::string::npos ? "" : name.substr(0, slash);
}

// The room around a folder, so many names deep: "pipeline/show" for "pipeline/show/stage" at 2.
inline std::string room_at(const std::string& folder, int level) {
  std::size_t end = 0;
  for (; level > 0 && end != std::string::npos; --level) end = folder.find('/', end + 1);
  return folder.substr(0, end);
}

inline std::string room_of(const std::string& name) {
  return room_at(name, 1);
}

inline SourceFile source_file(const std::string& name, std::istream& text) {
  static const std::regex include(R"(^\s*#\s*include\s*([<"])([^>"]+)[>"])");
  SourceFile file{name, folder_of(name), {}};
  for (std::string line; std::getline(text, line);) {
    std::smatch match;
    if (std::regex_search(line, match, include)) file.includes.push_back({match[2], match[1] == "\""});
  }
  return file;
}

inline bool is_code(const std::filesystem::path& file) {
  const auto extension = file.extension();
  return extension == ".cpp" || extension == ".hpp" || extension == ".glsl" || extension == ".vert" ||
         extension == ".frag";
}

// All code below a folder of the repository.
inline std::vector<SourceFile> source_files(const std::string& folder) {
  const std::filesystem::path root = source_folder();
  std::vector<SourceFile> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(root / folder)) {
    if (!entry.is_regular_file() || !is_code(entry.path())) continue;
    std::ifstream text(entry.path());
    files.push_back(source_file(std::filesystem::relative(entry.path(), root).string(), text));
  }
  return files;
}

}  // namespace kasumi::house
