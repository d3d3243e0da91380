#include "history/history_minute.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace kasumi {

namespace {

using namespace std::chrono_literals;

// How bad each is for a visitor.
int rank_of(Shown shown) {
  switch (shown) {
    case Shown::live: return 0;
    case Shown::dark: return 1;
    case Shown::degraded: return 2;
    case Shown::held: return 3;
    case Shown::still: return 4;
    case Shown::nothing: return 5;
  }
  return 0;
}

}  // namespace

bool is_as_it_should_be(Shown shown) {
  return shown == Shown::live || shown == Shown::degraded || shown == Shown::dark;
}

std::optional<HistoryLine> HistoryMinute::end() {
  auto ended = std::exchange(minute_, std::nullopt);
  if (ended) ended->hidden_s = static_cast<int>(std::lround(std::min(60.0, to_seconds(hidden_))));
  hidden_ = {};
  return ended;
}

std::optional<HistoryLine> HistoryMinute::add(const HistoryLine& now, Instant at) {
  std::optional<HistoryLine> ended;
  // Silence before this second is not counted, since the state then is unknown.
  const auto since = minute_ ? std::clamp(at - told_, Duration{}, Duration(2s)) : Duration{};
  told_ = at;
  if (minute_ && minute_->utc != now.utc) ended = end();
  auto worst = now;
  if (minute_ && rank_of(minute_->shown) >= rank_of(now.shown)) {
    worst.shown = minute_->shown;
    worst.trouble = minute_->trouble;
  }
  minute_ = worst;
  if (!is_as_it_should_be(now.shown)) hidden_ += since;
  return ended;
}

}  // namespace kasumi
