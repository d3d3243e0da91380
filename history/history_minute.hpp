// Gathers the status of each second into a line each minute.
#pragma once

#include "history/history_line.hpp"

namespace kasumi {

class HistoryMinute {
 public:
  // A second's state, its number and hidden_s left open. Gives the minute that has just ended, if one has: the worst rung
  // in it, and all else as it was last.
  std::optional<HistoryLine> add(const HistoryLine& now, Instant at);
  // The minute under way, as far as it has come: at a stop.
  std::optional<HistoryLine> end();

 private:
  std::optional<HistoryLine> minute_;
  Duration hidden_{};
  Instant told_{};
};

// Visitors see the live picture, or it is closed on purpose.
bool is_as_it_should_be(Shown shown);

}  // namespace kasumi
