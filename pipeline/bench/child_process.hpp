// Programs run beside, for `kasumi bench --peers`.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <sys/types.h>

#include "base/clock.hpp"
#include "base/result.hpp"

namespace kasumi {

struct ChildCost {
  double processor_s = 0.0;  // of the program and of those it waited for
  double wall_s = 0.0;
  int exit_code = -1;
  std::string last_words;  // the last line that it wrote to standard error
};

// Whether the program can be found along PATH.
bool is_installed(const std::string& program);

// Runs a program, its standard output thrown away, and waits for it; after `at_most` it is killed. Errors: io (not started),
// timeout.
Result<ChildCost> run_child(const std::vector<std::string>& command, Duration at_most);

// An X server without a screen while this lives; DISPLAY names it.
class VirtualDesktop {
 public:
  // Errors: unsupported (no Xvfb here), timeout.
  static Result<VirtualDesktop> start(int width, int height);
  VirtualDesktop(VirtualDesktop&& other) noexcept : server_(std::exchange(other.server_, 0)) {}
  VirtualDesktop& operator=(VirtualDesktop&&) = delete;
  ~VirtualDesktop();

 private:
  explicit VirtualDesktop(pid_t server) : server_(server) {}
  pid_t server_;
};

}  // namespace kasumi
