// Values formatted as TOML.
#pragma once

#include <string>
#include <string_view>

#include <fmt/format.h>

namespace kasumi {

// A basic string, in its quotes.
inline std::string toml_string(std::string_view text) {
  std::string result = "\"";
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\')
      result += fmt::format("\\{}", c);
    else if (code < 0x20 || code == 0x7f)
      result += fmt::format("\\u{:04X}", code);
    else
      result += c;
  }
  return result + "\"";
}

// The shortest digits that read back as the same value; TOML needs a point or an exponent to see a float.
inline std::string toml_number(double value) {
  auto text = fmt::format("{}", value);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

}  // namespace kasumi
