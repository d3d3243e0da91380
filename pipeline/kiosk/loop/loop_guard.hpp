// Keeps a loop going whose step throws (no memory, a library's exception): that step is lost, not the process and with
// it the picture. Exceptions do not leave a room, so each is a mistake; a kiosk outlives it.
#pragma once

#include <algorithm>
#include <exception>
#include <string>

#include <spdlog/spdlog.h>

#include "base/clock.hpp"

namespace kasumi {

class LoopGuard {
 public:
  // `name`: of the loop, in the journal.
  LoopGuard(std::string name, Clock& clock) : name_(std::move(name)), clock_(clock) {}

  // Takes one step. false: it threw; take the next at again_at().
  template <class Step>
  bool run(Step&& step) {
    try {
      step();
    } catch (const std::exception& thrown) {
      return threw(thrown.what());
    } catch (...) {
      return threw("unknown exception");
    }
    if (failures_ > 0) recovered();
    return true;
  }
  // 1, 2, 3, 3 .. s after the first, second .. step in a row that threw.
  Instant again_at() const { return again_at_; }

 private:
  static constexpr Duration kFirstPause = std::chrono::seconds(1);
  static constexpr Duration kLongestPause = std::chrono::seconds(3);  // a loop that is silent for 5 s counts as hung

  bool threw(const char* why) {
    if (failures_ == 0) spdlog::error("{}: failed, trying again: {}", name_, why);
    again_at_ = clock_.now() + std::min(kFirstPause * (1 << std::min(failures_, 4)), kLongestPause);
    ++failures_;
    return false;
  }
  void recovered() {
    spdlog::info("{}: works again after {} failures", name_, failures_);
    failures_ = 0;
  }

  std::string name_;
  Clock& clock_;
  int failures_ = 0;  // in a row
  Instant again_at_{};
};

}  // namespace kasumi
