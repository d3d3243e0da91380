// The state page: what a person far away needs to know, on a telephone, by keyboard or read aloud.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/words/language.hpp"
#include "history/history_line.hpp"
#include "report/diagnosis/diagnosis.hpp"
#include "report/page/screen_asking.hpp"
#include "report/web/content_pull.hpp"

namespace kasumi::report {

// The part of the page that shows the screen on request.
struct ScreenPart {
  std::string key;  // that the form sends, so that no page elsewhere can send it
  std::optional<ScreenReply> reply{};
};

struct StatePage {
  std::string name;  // of the kiosk
  Heard heard;
  std::vector<HistoryLine> history;  // in the order in which they were written; empty: none is kept
  Utc now{};
  std::chrono::minutes wall{};         // wall time ahead of UTC
  std::optional<PullStatus> pull{};    // where content is asked for
  std::optional<ScreenPart> screen{};  // where it may be asked for
};

// HTML without script; its style is page_style() at "style.css". Everything that the kiosk tells is escaped.
std::string state_page(const StatePage& page, Language language);
std::string_view page_style();

// Of "?language=", then of an Accept-Language header by its order, then the fallback.
Language wanted_language(std::string_view asked, std::string_view accept_language, Language fallback);

}  // namespace kasumi::report
