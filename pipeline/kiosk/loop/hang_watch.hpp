// Logs once each which loops hang and which are back.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pipeline/kiosk/loop/pulse.hpp"

namespace kasumi {

// "hung: silent for 34 s, in a call that does not return"
std::string hung_text(Duration silent);

class HangWatch {
 public:
  // The pulses must outlive it.
  explicit HangWatch(std::vector<const Pulse*> pulses);
  void look(Instant now);

 private:
  struct Watched {
    const Pulse* pulse;
    bool hung = false;
    Instant since{};
  };
  std::vector<Watched> watched_;
};

}  // namespace kasumi
