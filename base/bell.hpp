// Wakes one waiting thread: rung by whoever has news for it.
#pragma once

#include <condition_variable>
#include <mutex>

#include "base/clock.hpp"

namespace kasumi {

class Bell {
 public:
  void ring() {
    const std::lock_guard lock(mutex_);
    rung_ = true;
    woken_.notify_all();
  }
  // BLOCKS until it rings (at once when it has rung since the last wait) or the time is over, by the machine's clock.
  // true: it rang.
  bool wait_for(Duration longest) {
    std::unique_lock lock(mutex_);
    const bool rang = woken_.wait_for(lock, longest, [this] { return rung_; });
    rung_ = false;
    return rang;
  }

 private:
  std::mutex mutex_;
  std::condition_variable woken_;
  bool rung_ = false;
};

}  // namespace kasumi
