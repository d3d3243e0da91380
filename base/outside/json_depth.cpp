#include "base/outside/json_depth.hpp"

#include <algorithm>

namespace kasumi {

int json_depth(std::string_view json) {
  int depth = 0, deepest = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (in_string) {
      if (c == '\\')
        ++i;
      else if (c == '"')
        in_string = false;
    } else if (c == '"') {
      in_string = true;
    } else if (c == '[' || c == '{') {
      deepest = std::max(deepest, ++depth);
    } else if (c == ']' || c == '}') {
      --depth;
    }
  }
  return deepest;
}

std::string_view modest_json(std::string_view json, std::size_t most_bytes, int deepest) {
  return json.size() <= most_bytes && json_depth(json) <= deepest ? json : std::string_view();
}

}  // namespace kasumi
