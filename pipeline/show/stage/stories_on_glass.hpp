// Whether what visitors may ask for can be seen and read.
#pragma once

#include <string>
#include <vector>

#include "pipeline/site/config/content.hpp"

namespace kasumi {

// For people, one line each, with file and key: a story whose place the kiosk never shows; a text that is too long for its
// panel beside the building, or has letters that no installed font can show. Empty: all is well, or there are none.
std::vector<std::string> stories_that_cannot_be_seen(const Content& content);

}  // namespace kasumi
