// The results of all inputs of `kasumi estimate`, and its exit code.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>

#include "estimator/atmosphere.hpp"

namespace kasumi {

// In few words that others may share: what the sky is, else the reason in full.
std::string why_useless(const TurbidityEstimate& estimate);

class EstimateTally {
 public:
  void useful() { ++useful_; }
  void useless(const std::string& why) { ++useless_[why]; }
  void unread() { ++unread_; }

  // 0: some input determined the air; 1: all could be read, but none did; 2: an input could not be read.
  int exit_code() const { return unread_ > 0 ? 2 : useful_ > 0 ? 0 : 1; }
  // Why the air is unknown; empty: it is known. `what`: "picture". "none of 3 pictures determines the air: 2 x
  // overcast; 1 x night".
  std::string told(std::string_view what) const;

 private:
  std::size_t useful_ = 0, unread_ = 0;
  std::map<std::string, std::size_t> useless_;  // how many, by why
};

}  // namespace kasumi
