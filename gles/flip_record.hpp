// Flips until somebody takes them: the newest ones only, so that nobody who forgets to ask runs out of memory.
#pragma once

#include <utility>
#include <vector>

#include "gles/display.hpp"

namespace kasumi {

class FlipRecord {
 public:
  void add(std::uint64_t number, Instant at) {
    if (flips_.size() == kKept) flips_.erase(flips_.begin());
    flips_.push_back({number, at});
    ++count_;
  }
  std::vector<Flip> take() { return std::exchange(flips_, {}); }
  std::uint64_t count() const { return count_; }

 private:
  static constexpr std::size_t kKept = 256;
  std::vector<Flip> flips_;
  std::uint64_t count_ = 0;
};

}  // namespace kasumi
