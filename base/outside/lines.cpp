#include "base/outside/lines.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace kasumi {

namespace {

void make_plain(std::string& line) {
  if (line.size() > kMostProblemBytes) {
    auto end = kMostProblemBytes;
    while (end > 0 && (static_cast<unsigned char>(line[end]) & 0xc0u) == 0x80u) --end;  // whole characters
    line.resize(end);
    line += "...";
  }
  for (char& c : line)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
}

}  // namespace

std::vector<std::string> lines_of(std::string_view text) {
  std::vector<std::string> lines;
  std::size_t more = 0;
  while (!text.empty()) {
    const auto end = std::min(text.find('\n'), text.size());
    const auto line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (!lines.empty() && more == 0 && lines.back().ends_with(':'))
      lines.back().append(" ").append(line);
    else if (lines.size() < kMostProblems)
      lines.emplace_back(line);
    else
      ++more;
  }
  for (auto& line : lines) make_plain(line);
  if (more > 0) lines.push_back(fmt::format("and {} more", more));
  return lines;
}

}  // namespace kasumi
