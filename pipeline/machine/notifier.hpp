// Reports the program's state to the service manager.
#pragma once

#include <memory>
#include <string>

#include "base/clock.hpp"

namespace kasumi {

class Notifier {
 public:
  virtual ~Notifier() = default;
  virtual void ready() = 0;  // the visitor sees something
  virtual void status(const std::string& line) = 0;
  virtual void alive() = 0;                    // feeds the watchdog
  virtual void extend_start(Duration by) = 0;  // still waiting for what ready() needs
  virtual void reloading() = 0;                // ends with ready()
  virtual void stopping() = 0;
};

// As $NOTIFY_SOCKET says; without a service manager nothing happens. Any thread, never waits: a manager that does not
// read gets the newest message of each kind once it does.
std::unique_ptr<Notifier> notify_systemd();

}  // namespace kasumi
