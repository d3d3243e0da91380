// Keeps flips until they are taken, but only the newest, so that memory stays bounded if they never are.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "gles/display/display.hpp"

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

// Numbers the pictures of a display whose flips complete immediately.
class ImmediateFlips {
 public:
  explicit ImmediateFlips(Clock& clock) : clock_(clock) {}
  // The picture is shown, and the one before is no longer read. Returns its number.
  std::uint64_t shown(std::shared_ptr<const void> until_replaced) {
    held_ = std::move(until_replaced);
    record_.add(++number_, clock_.now());
    return number_;
  }
  std::uint64_t number() const { return number_; }  // of the picture shown last; 0: none yet
  std::vector<Flip> take() { return record_.take(); }
  DisplayCounts counts() const { return {.flips = record_.count()}; }

 private:
  Clock& clock_;
  std::uint64_t number_ = 0;
  std::shared_ptr<const void> held_;
  FlipRecord record_;
};

}  // namespace kasumi
