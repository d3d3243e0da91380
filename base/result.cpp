#include "base/result.hpp"

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

Fault Problems::fault() const {
  return Fault{FaultKind::bad_input, fmt::format("{}", fmt::join(lines_, "\n"))};
}

}  // namespace kasumi
