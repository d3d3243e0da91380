// UTC as ISO 8601 text, for indexes and logs.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "base/clock.hpp"

namespace kasumi {

// "2026-06-21T03:00:00Z", with 3, 6 or 9 decimals of a second where needed to be exact.
std::string utc_text(Utc utc);
// Parses the same format with 0 to 9 decimals, years 1970 to 2261; empty for anything else.
std::optional<Utc> parse_utc(std::string_view text);

}  // namespace kasumi
