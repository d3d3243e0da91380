// What JSON may cost, seen before it is parsed: each level of nesting takes memory, and stack where somebody recurses.
#pragma once

#include <cstddef>
#include <string_view>

namespace kasumi {

// Brackets within texts do not count.
int json_depth(std::string_view json);

// The text itself, or nothing (which no parser takes for JSON) where it is larger or deeper than what Kasumi's programs
// tell each other and keep.
std::string_view modest_json(std::string_view json, std::size_t most_bytes = 1 << 20, int deepest = 32);

}  // namespace kasumi
