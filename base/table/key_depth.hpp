// How deep a TOML text's keys are, before it is parsed: toml++ 3.3 bounds the depth of nested values but not that of keys, and a
// key of 130,000 parts overflows the stack.
#pragma once

#include <string_view>

namespace kasumi {

// Parts of the longest key: 3 for "a.b.c = 1". A number or a time of day counts as 2 at most.
int deepest_key(std::string_view toml);

}  // namespace kasumi
