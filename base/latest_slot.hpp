// The one hand-off between threads: holds the newest value, counts what it dropped.
#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <utility>

namespace kasumi {

template <class T>
class LatestSlot {
 public:
  // Replaces a value nobody has taken yet.
  void put(T value) {
    const std::lock_guard lock(mutex_);
    if (value_) ++dropped_;
    value_ = std::move(value);
  }

  // The newest value, once; empty when nothing new has come.
  std::optional<T> take() {
    const std::lock_guard lock(mutex_);
    return std::exchange(value_, std::nullopt);
  }

  std::uint64_t dropped() const {
    const std::lock_guard lock(mutex_);
    return dropped_;
  }

 private:
  mutable std::mutex mutex_;
  std::optional<T> value_;
  std::uint64_t dropped_ = 0;
};

}  // namespace kasumi
