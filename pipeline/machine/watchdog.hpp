// Reports the render loop's progress to the service manager. Only pictures that reached the display count, or the
// certainty that none is connected: when the loop hangs or the display accepts no picture, the service is restarted;
// and when a camera's loop has hung for long.
#pragma once

#include <optional>

#include "pipeline/machine/notifier.hpp"

namespace kasumi {

class Watchdog {
 public:
  explicit Watchdog(Notifier& notifier) : notifier_(notifier) {}

  // A picture is on the display.
  void picture_shown(Instant now) {
    if (!ready_) notifier_.ready();
    ready_ = true;
    feed(now);
  }
  // No display is connected (a television is off at night), but the loop keeps checking.
  void display_missing(Instant now) {
    if (!ready_ && !withheld_ && (!extended_ || now - *extended_ >= kExtendInterval)) {
      notifier_.extend_start(3 * kExtendInterval);
      extended_ = now;
    }
    feed(now);
  }
  // A camera's loop has hung for long: a restart is the only help left.
  void withhold(bool withheld) { withheld_ = withheld; }
  // Outside opening hours: the screen is off, and the loop waits for the time to open.
  void display_off(Instant now) { feed(now); }

 private:
  static constexpr Duration kFeedInterval = std::chrono::seconds(1);
  static constexpr Duration kExtendInterval = std::chrono::seconds(10);
  void feed(Instant now) {
    if (withheld_) return;
    if (fed_ && now - *fed_ < kFeedInterval) return;
    notifier_.alive();
    fed_ = now;
  }

  Notifier& notifier_;
  bool ready_ = false;
  bool withheld_ = false;
  std::optional<Instant> fed_, extended_;
};

}  // namespace kasumi
