// Programs run beside, for `kasumi bench --peers` and `--memory`.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <sys/types.h>

#include "base/clock.hpp"
#include "base/result.hpp"
#include "base/unique_fd.hpp"

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

// A program that runs until this ends. Its standard output is thrown away.
class Child {
 public:
  // Errors: io.
  static Result<Child> start(const std::vector<std::string>& command);
  Child(Child&& other) noexcept : pid_(std::exchange(other.pid_, 0)), errors_(std::move(other.errors_)) {}
  Child& operator=(Child&&) = delete;
  ~Child();
  pid_t pid() const { return pid_; }
  bool is_running() const;
  std::string last_words() const;  // the last line that it wrote to standard error

 private:
  Child(pid_t pid, UniqueFd errors) : pid_(pid), errors_(std::move(errors)) {}
  pid_t pid_;
  UniqueFd errors_;
};

// A temporary folder, removed with all that is in it when this ends.
class WorkFolder {
 public:
  WorkFolder();
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;
  ~WorkFolder();
  const std::filesystem::path& path() const { return path_; }  // empty: none could be made

 private:
  std::filesystem::path path_;
};

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
