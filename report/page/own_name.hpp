// Whether a peer asked for us, or was led here by a page elsewhere.
#pragma once

#include <string>
#include <vector>

namespace kasumi::report {

// By a Host header. A page elsewhere must not read ours through a name of its own that leads here (DNS rebinding):
// numbers and localhost cannot be such.
bool is_own_name(std::string host, const std::vector<std::string>& names);

}  // namespace kasumi::report
