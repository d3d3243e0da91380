// Keeps a television as it is wanted: on before opening, asleep after closing. One that does not answer is logged once
// and costs nothing: after a few tries it is left alone until the next change.
#pragma once

#include <optional>
#include <string>

#include "base/clock.hpp"
#include "pipeline/machine/devices.hpp"

namespace kasumi {

struct TelevisionStatus {
  std::string adapter;                               // "/dev/cec0"; empty: none is switched
  std::optional<bool> wanted_on;                     // empty: nothing was asked of it yet
  std::optional<bool> answers;                       // empty: not tried yet
  std::string problem;                               // why it does not
  TelevisionPower power = TelevisionPower::unknown;  // by its last report
};

class TelevisionSwitch {
 public:
  // `adapter`: empty: none. `devices` and `clock` must outlive it.
  TelevisionSwitch(std::string adapter, Devices& devices, Clock& clock);
  void use(const std::string& adapter);
  void want(bool on);
  // BLOCKS for a few seconds when something is to be done. Returns when to be called again unless wants change.
  Instant step();
  const TelevisionStatus& status() const { return status_; }

 private:
  void begin();
  Result<> switch_it();
  void tell(const Result<>& done);

  Devices& devices_;
  Clock& clock_;
  int tries_left_ = 0;
  bool sent_ = false;  // it has taken the message, and should be as it is wanted
  Instant again_;
  TelevisionStatus status_;
};

}  // namespace kasumi
