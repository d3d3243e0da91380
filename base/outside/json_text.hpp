// JSON to and from text, compiled once: each file that did it by itself took a second longer to compile, and seven with the
// address sanitizer.
#pragma once

#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

namespace kasumi {

// is_discarded(): `text` is no JSON. What comes from outside is bounded first (modest_json).
nlohmann::json parse_json(std::string_view text);
nlohmann::ordered_json parse_ordered_json(std::string_view text);

// indent < 0: one line. Bytes that are not UTF-8 become U+FFFD.
std::string text_of_json(const nlohmann::json& json, int indent = -1);
std::string text_of_json(const nlohmann::ordered_json& json, int indent = -1);

}  // namespace kasumi
