#include "base/result.hpp"

#include <algorithm>
#include <unordered_set>

namespace kasumi {

std::string_view name_of(FaultKind kind) {
  switch (kind) {
    case FaultKind::bad_input: return "bad input";
    case FaultKind::io: return "input/output";
    case FaultKind::timeout: return "timeout";
    case FaultKind::disconnected: return "disconnected";
    case FaultKind::end_of_stream: return "end of stream";
    case FaultKind::unsupported: return "unsupported";
    case FaultKind::device: return "device";
  }
  return "unknown";
}

// Each line once: what several readers of a file need, each of them misses. Lines that another line announces ("... can
// be read:") stay with it.
Fault Problems::fault() const {
  std::unordered_set<std::string_view> told;
  std::vector<std::string_view> lines;
  for (const std::string_view problem : lines_) {
    bool announced = false;
    for (std::size_t from = 0; from <= problem.size();) {
      const auto end = std::min(problem.find('\n', from), problem.size());
      const auto line = problem.substr(from, end - from);
      const bool is_new = told.insert(line).second;
      if (is_new || announced) lines.push_back(line);
      announced = announced || (is_new && line.ends_with(':'));
      from = end + 1;
    }
  }
  return Fault{FaultKind::bad_input, fmt::format("{}", fmt::join(lines, "\n"))};
}

}  // namespace kasumi
