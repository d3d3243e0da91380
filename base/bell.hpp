// Wakes one waiting thread.
#pragma once

#include <chrono>
#include <condition_variable>
#include <utility>

#include "base/clock.hpp"
#include "base/thread_annotations.hpp"

namespace kasumi {

class Bell {
 public:
  void ring() {
    const MutexLock lock(mutex_);
    rung_ = true;
    woken_.notify_all();
  }
  // BLOCKS until it rings or the time has passed, by the machine's clock. Returns at once if it has rung since the last
  // wait. true: it rang.
  bool wait_for(Duration longest) {
    const auto until = std::chrono::steady_clock::now() + longest;
    const MutexLock lock(mutex_);
    bool in_time = true;
    while (!rung_ && in_time) in_time = woken_.wait_until(mutex_, until) == std::cv_status::no_timeout;
    return std::exchange(rung_, false);
  }

 private:
  Mutex mutex_;
  std::condition_variable_any woken_;
  bool rung_ KASUMI_GUARDED_BY(mutex_) = false;
};

}  // namespace kasumi
