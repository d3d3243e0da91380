// The kiosk's state for a person at a terminal.
#pragma once

#include <string>

#include "base/words/language.hpp"
#include "report/diagnosis/status_watch.hpp"

namespace kasumi::report {

// What visitors see, and what is wrong with what to do about it: several lines.
std::string state_text(const Heard& heard, Language language);

}  // namespace kasumi::report
