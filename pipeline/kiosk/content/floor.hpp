// The oldest date that unattended content may have: signed bundles stay valid for ever, so an old one could bring back
// replaced content. The date of the newest bundle ever installed is kept in a file of its own, FOLDER/floor.
#pragma once

#include <filesystem>
#include <optional>

#include "base/clock.hpp"
#include "base/result.hpp"

namespace kasumi {

// The latest date that a bundle may bear: a day from now where the clock is trusted; a year where it is not trusted,
// but not before this program was built either; empty: the clock is of no use.
std::optional<Utc> latest_believable(Utc now, bool clock_trusted);

// Empty: none was installed yet, or its date is beyond `latest`, which only a wrong clock can have accepted.
std::optional<Utc> read_floor(const std::filesystem::path& folder, const std::optional<Utc>& latest);
// Never lowers it. Error: io.
Result<> raise_floor(const std::filesystem::path& folder, Utc to, const std::optional<Utc>& latest);
// Sets it, whatever it was; for a person to do. Error: io.
Result<> set_floor(const std::filesystem::path& folder, Utc to);

}  // namespace kasumi
