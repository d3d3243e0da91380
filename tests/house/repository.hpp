// The files of the repository as the tests of this folder read them.
#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "base/files.hpp"
#include "tests/places.hpp"

namespace kasumi::house {

using Texts = std::map<std::string, std::string>;  // by name from the root, like "docs/sky.md"

// Every file of the checkout, by name from the root, without build outputs and hidden files.
inline std::set<std::string> repository_files() {
  const auto root = source_folder();
  std::set<std::string> names;
  for (auto entry = std::filesystem::recursive_directory_iterator(root); entry != end(entry); ++entry) {
    const auto name = entry->path().filename().string();
    if (entry->is_directory() && (name.starts_with(".") || name.starts_with("build") || name == "out"))
      entry.disable_recursion_pending();
    else if (entry->is_regular_file())
      names.insert(std::filesystem::relative(entry->path(), root).generic_string());
  }
  return names;
}

// The texts of files with these endings.
inline Texts texts_ending_in(const std::set<std::string>& files, const std::vector<std::string>& endings) {
  Texts texts;
  for (const auto& name : files) {
    bool wanted = false;
    for (const auto& ending : endings) wanted = wanted || name.ends_with(ending);
    if (!wanted) continue;
    texts[name] = read_text_file(source_folder() / name).value();
  }
  return texts;
}

inline std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

// The lines of a Markdown text outside its blocks of code, which stand between fences or are indented by four.
inline std::vector<std::string> lines_of_prose(const std::string& text) {
  std::vector<std::string> prose;
  bool fenced = false;
  for (const auto& line : lines_of(text)) {
    const bool fence = line.starts_with("```");
    if (fence) fenced = !fenced;
    if (!fence && !fenced && !line.starts_with("    ")) prose.push_back(line);
  }
  return prose;
}

// "Two turbidities" of "## Two turbidities".
inline std::vector<std::string> headings_of(const std::string& text) {
  std::vector<std::string> headings;
  for (const auto& line : lines_of_prose(text)) {
    const auto hashes = line.find_first_not_of('#');
    if (hashes != std::string::npos && hashes > 0 && line[hashes] == ' ') headings.push_back(line.substr(hashes + 1));
  }
  return headings;
}

}  // namespace kasumi::house
