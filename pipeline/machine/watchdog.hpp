// What the service manager is told of the render loop's progress. Only pictures that reached the glass count, or the
// certainty that there is no glass: a loop that hangs, or a display that takes no picture, is restarted.
#pragma once

#include <optional>

#include "pipeline/machine/notifier.hpp"

namespace kasumi {

class Watchdog {
 public:
  explicit Watchdog(Notifier& notifier) : notifier_(notifier) {}

  // A picture is on the glass: ready, and alive.
  void picture_shown(Instant now) {
    if (!ready_) notifier_.ready();
    ready_ = true;
    feed(now);
  }
  // No display is connected (a television is off at night); the loop went to look again.
  void display_missing(Instant now) {
    if (!ready_ && (!extended_ || now - *extended_ >= kExtendInterval)) {
      notifier_.extend_start(3 * kExtendInterval);
      extended_ = now;
    }
    feed(now);
  }
  // Closed: the screen is off, and the loop looks whether it is time to open.
  void display_off(Instant now) { feed(now); }

 private:
  static constexpr Duration kFeedInterval = std::chrono::seconds(1);
  static constexpr Duration kExtendInterval = std::chrono::seconds(10);
  void feed(Instant now) {
    if (fed_ && now - *fed_ < kFeedInterval) return;
    notifier_.alive();
    fed_ = now;
  }

  Notifier& notifier_;
  bool ready_ = false;
  std::optional<Instant> fed_, extended_;
};

}  // namespace kasumi
