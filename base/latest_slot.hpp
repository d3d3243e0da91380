// Hands values from one thread to another: holds the newest value and counts those it dropped.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>

#include "base/thread_annotations.hpp"

namespace kasumi {

template <class T>
class LatestSlot {
 public:
  // Replaces a value that was not taken yet.
  void put(T value) {
    std::optional<T> replaced(std::move(value));
    {
      const MutexLock lock(mutex_);
      value_.swap(replaced);
      if (replaced) ++dropped_;
    }
    // The replaced value ends here, without the lock: a frame may go back to a driver, which takes its time.
  }

  // The newest value, once; empty when there is no new one.
  std::optional<T> take() {
    const MutexLock lock(mutex_);
    return std::exchange(value_, std::nullopt);
  }

  std::uint64_t dropped() const {
    const MutexLock lock(mutex_);
    return dropped_;
  }

 private:
  mutable Mutex mutex_;
  std::optional<T> value_ KASUMI_GUARDED_BY(mutex_);
  std::uint64_t dropped_ KASUMI_GUARDED_BY(mutex_) = 0;
};

}  // namespace kasumi
