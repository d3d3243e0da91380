// How old content may be that comes by itself: signed bundles stay signed for ever, and whoever has an old one could bring
// back what was replaced. The date of the newest that was ever taken is kept in a file of its own, FOLDER/floor.
#pragma once

#include <filesystem>
#include <optional>

#include "base/clock.hpp"
#include "base/result.hpp"

namespace kasumi {

// The latest date that a bundle may bear: a day from now where the clock is trusted; a year where it is not, but is not
// before this program either; empty: by such a clock nothing is known.
std::optional<Utc> latest_believable(Utc now, bool clock_trusted);

// Empty: none was taken yet, or its date is beyond `latest` and was believed by a clock that was wrong.
std::optional<Utc> read_floor(const std::filesystem::path& folder, const std::optional<Utc>& latest);
// Never lowers it. Error: io.
Result<> raise_floor(const std::filesystem::path& folder, Utc to, const std::optional<Utc>& latest);
// Sets it, whatever it was; for a person to do. Error: io.
Result<> set_floor(const std::filesystem::path& folder, Utc to);

}  // namespace kasumi
