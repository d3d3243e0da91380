#include "base/table/key_depth.hpp"

#include <algorithm>
#include <string>

namespace kasumi {
namespace {

// Behind the string that begins at `at`. One that nothing closes ends with its line or with the text, where toml++ gives up.
std::size_t behind_string(std::string_view text, std::size_t at) {
  const char quote = text[at];
  const bool escapes = quote == '"';
  const std::string fence(3, quote);
  const bool long_one = text.substr(at, 3) == fence;
  at += long_one ? 3 : 1;
  for (; at < text.size(); ++at) {
    if (escapes && text[at] == '\\') {
      ++at;
    } else if (long_one) {
      if (text.substr(at, 3) != fence) continue;
      at += 3;
      for (int more = 0; more < 2 && at < text.size() && text[at] == quote; ++more) ++at;  // of the string's own
      return at;
    } else if (text[at] == quote || text[at] == '\n') {
      return at + 1;
    }
  }
  return text.size();
}

}  // namespace

int deepest_key(std::string_view toml) {
  int deepest = 0, parts = 1;
  for (std::size_t at = 0; at < toml.size();) {
    const char c = toml[at];
    if (c == '"' || c == '\'') {
      at = behind_string(toml, at);
      continue;
    }
    if (c == '#')
      at = std::min(toml.find('\n', at), toml.size());
    else
      ++at;
    if (c == '.')
      deepest = std::max(deepest, ++parts);
    else if (c == '\n' || c == '=' || c == ',' || c == '{' || c == '[')
      parts = 1;
    deepest = std::max(deepest, parts);
  }
  return deepest;
}

}  // namespace kasumi
