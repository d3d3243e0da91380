// What a start of the appliance shows: what is configured or, if that is refused or makes start after start fail, what
// worked last. Of content in generations that is the generation before; of a configuration set up by hand the copies
// that were kept of it (pipeline/kiosk/start/kept_content.hpp).
#pragma once

#include "pipeline/kiosk/content/generations.hpp"
#include "pipeline/kiosk/start/start_log.hpp"
#include "pipeline/site/config/content.hpp"

namespace kasumi {

// A generation that is refused while it is on probation, or whose starts have failed five times, goes back for good.
// One that has served it stays the current one, for what made it fail may pass; shown is the one before, and
// `Content::instead` says why. `kept_folder`: of copies; empty: none are kept.
// Errors: those of the configuration set up by hand, when nothing else can be shown either.
Result<ContentPtr> content_at_start(const ContentPlace& place, StartLog& starts,
                                    const std::filesystem::path& kept_folder, Utc now);

// What to show instead of content that was read and then could not be drawn, by the same rules. Error (bad_input, io):
// there is nothing else.
Result<ContentPtr> content_instead(const ContentPlace& place, const Content& refused,
                                   const std::filesystem::path& kept_folder, std::vector<std::string> problems,
                                   Utc now);

}  // namespace kasumi
