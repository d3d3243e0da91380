// Text for man(7).
#pragma once

#include <string>
#include <string_view>

namespace kasumi {

// Whatever it says, shown as it is.
inline std::string roff(std::string_view text) {
  std::string shown = !text.empty() && (text[0] == '.' || text[0] == '\'') ? "\\&" : "";
  for (const char c : text) {
    if (c == '\\')
      shown += "\\e";
    else if (c == '-')
      shown += "\\-";
    else if (c == '"')
      shown += "\\(dq";
    else if (c == '`')
      shown += "\\(ga";
    else if (c == '\'')
      shown += "\\(aq";
    else if (c == '^')
      shown += "\\(ha";
    else if (c == '~')
      shown += "\\(ti";
    else
      shown += c;
  }
  return shown;
}

}  // namespace kasumi
