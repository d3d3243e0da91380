// Disk writes for threads that must not wait: a disk may take seconds, or never answer. Jobs run one after the other in
// a thread of their own.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "base/clock.hpp"

namespace kasumi {

// Thread-safe. Its thread is left behind where a job never ends; hence a job must own all that it uses.
class StateWriter {
 public:
  StateWriter();
  ~StateWriter();  // BLOCKS for a second at most: what is not written by then stays unwritten

  // In the place of a job of that name which has not begun. `not_before`: from now.
  void post(const std::string& name, std::function<void()> job, Duration not_before = {});
  // BLOCKS until all that was posted is done, whatever its time, for at most `longest`. false: it is not.
  bool flush(Duration longest);
  // Posts it and BLOCKS until all is done, for at most `longest`, and not at all while a job has been hanging for so
  // long. false: it is not done yet.
  bool do_now(const std::string& name, std::function<void()> job, Duration longest);
  // How long the job under way has been taking, by the machine's clock; empty: there is none.
  std::optional<Duration> busy() const;

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
};

}  // namespace kasumi
