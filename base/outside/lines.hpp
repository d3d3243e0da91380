// A fault's problems: its message has a line for each, and of one that another file explains a second.
#pragma once

#include <sstream>
#include <string>
#include <vector>

namespace kasumi {

// What a line announces (it ends in a colon) stays with it: it is one problem.
inline std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    const bool announced = !lines.empty() && lines.back().ends_with(':');
    announced ? lines.back().append(" " + line) : lines.emplace_back(line);
  }
  return lines;
}

}  // namespace kasumi
