// The code in a document: its blocks, and what its sentences have between backticks.
#pragma once

#include <algorithm>
#include <regex>
#include <string>
#include <vector>

#include "tests/house/repository.hpp"

namespace kasumi::house {

struct DocumentCode {
  int line = 0;
  std::string text;      // of a block without its indentation, of a sentence's code without line breaks
  bool block = false;    // typed or copied as it is; else named in a sentence
  std::string language;  // of a fenced block: "toml"
};

inline std::vector<DocumentCode> code_in(const std::string& document) {
  std::vector<DocumentCode> found;
  std::string prose;  // with empty lines in place of blocks
  bool fenced = false, in_block = false;
  int number = 0;
  for (const auto& line : lines_of(document)) {
    ++number;
    const bool fence = line.starts_with("```"), indented = !fenced && line.starts_with("    ");
    if (fence) {
      fenced = !fenced;
      if (fenced) found.push_back({number, "", true, line.substr(3)});
    } else if (fenced) {
      found.back().text += line + "\n";
    } else if (indented) {
      if (!in_block) found.push_back({number, "", true, ""});
      found.back().text += line.substr(4) + "\n";
    }
    in_block = indented;
    prose += (fence || fenced || indented ? "" : line) + "\n";
  }
  static const std::regex kCode("`([^`]+)`"), kBreak(R"(\s*\n\s*)");
  for (std::sregex_iterator code(prose.begin(), prose.end(), kCode), last; code != last; ++code) {
    const auto before = prose.begin() + code->position();
    const auto line = static_cast<int>(std::count(prose.begin(), before, '\n')) + 1;
    const auto text = (*code)[1].str();
    if (text.find("\n\n") == std::string::npos)
      found.push_back({line, std::regex_replace(text, kBreak, " "), false, ""});
  }
  return found;
}

// The command lines in a piece of code, joined where they end in a backslash, without comments, and apart at `&&`, `|`
// and `;`.
inline std::vector<std::string> command_lines_in(const DocumentCode& code) {
  static const std::regex kContinued(R"(\\\n\s*)"), kComment(R"((^|\s)# .*)"), kApart(R"(\s*(&&|\||;)\s*)");
  std::vector<std::string> commands;
  for (const auto& typed : lines_of(std::regex_replace(code.text, kContinued, ""))) {
    const auto line = std::regex_replace(typed, kComment, "");
    for (std::sregex_token_iterator part(line.begin(), line.end(), kApart, -1), last; part != last; ++part)
      if (part->length() > 0) commands.push_back(*part);
  }
  return commands;
}

// The words of a command line as a shell takes them, without quotes, redirections and the brackets around what may be
// left out.
inline std::vector<std::string> words_of_command(const std::string& line) {
  static const std::regex kWord(R"re((?:[^\s"']|"[^"]*"|'[^']*')+)re"), kMarks(R"re(["'\[\]])re");
  std::vector<std::string> words;
  for (std::sregex_iterator word(line.begin(), line.end(), kWord), last; word != last; ++word) {
    if (word->str().starts_with(">")) break;
    words.push_back(std::regex_replace(word->str(), kMarks, ""));
  }
  return words;
}

}  // namespace kasumi::house
