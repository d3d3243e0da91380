#include "pipeline/kiosk/loop/hang_watch.hpp"

#include <spdlog/spdlog.h>

namespace kasumi {

std::string hung_text(Duration silent) {
  return fmt::format("hung: silent for {:.0f} s, in a call that does not return", to_seconds(silent));
}

HangWatch::HangWatch(std::vector<const Pulse*> pulses) {
  for (const auto* pulse : pulses) watched_.push_back({pulse});
}

void HangWatch::look(Instant now) {
  for (auto& watched : watched_) {
    const auto silent = watched.pulse->hung(now);
    if (silent.has_value() == watched.hung) continue;
    watched.hung = silent.has_value();
    if (silent) {
      watched.since = now - *silent;
      spdlog::warn("{} loop: {}", watched.pulse->name(), hung_text(*silent));
    } else {
      spdlog::info("{} loop: back after {:.0f} s", watched.pulse->name(), to_seconds(now - watched.since));
    }
  }
}

}  // namespace kasumi
