// The cost of JSON, bounded before it is parsed: each level of nesting takes memory, and stack in recursive code.
#pragma once

#include <cstddef>
#include <string_view>

namespace kasumi {

// Brackets within texts do not count.
int json_depth(std::string_view json);
// Of texts, numbers, lists and objects, one or two more than there are.
std::size_t json_values(std::string_view json);

// The text itself, or nothing (which no parser takes for JSON) where it is larger or deeper than any message or file of
// Kasumi's.
std::string_view modest_json(std::string_view json, std::size_t most_bytes = 1 << 20, int deepest = 32);

}  // namespace kasumi
