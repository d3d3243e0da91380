#include "base/outside/json_depth.hpp"

#include <algorithm>

namespace kasumi {

namespace {

// Calls `visit` for each character outside of texts.
template <class Visit>
void each_outside_texts(std::string_view json, Visit visit) {
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
    } else {
      visit(c);
    }
  }
}

}  // namespace

int json_depth(std::string_view json) {
  int depth = 0, deepest = 0;
  each_outside_texts(json, [&](char c) {
    if (c == '[' || c == '{') deepest = std::max(deepest, ++depth);
    if (c == ']' || c == '}') --depth;
  });
  return deepest;
}

std::size_t json_values(std::string_view json) {
  std::size_t values = 1;
  each_outside_texts(json, [&](char c) { values += c == ',' || c == '[' || c == '{'; });
  return values;
}

std::string_view modest_json(std::string_view json, std::size_t most_bytes, int deepest) {
  return json.size() <= most_bytes && json_depth(json) <= deepest ? json : std::string_view();
}

}  // namespace kasumi
