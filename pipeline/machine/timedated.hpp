// Asks systemd-timedated over the system bus whether the clock is synchronized, by whomever.
#pragma once

#include <memory>

namespace kasumi {

class Timedated {
 public:
  virtual ~Timedated() = default;
  // The latest answer; false until there is one. Asks again every ten seconds. Does not block.
  virtual bool synchronized() = 0;
};
std::unique_ptr<Timedated> ask_timedated();

}  // namespace kasumi
