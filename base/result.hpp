// Results and faults: what every fallible function of Kasumi returns. Exceptions do not leave a room.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <tl/expected.hpp>

namespace kasumi {

enum class FaultKind {
  bad_input,      // a file, image, model, option or configuration that a person must correct; exit code 2
  io,             // reading or writing failed (permissions, full disk)
  timeout,        // a deadline passed
  disconnected,   // a device is no longer there
  end_of_stream,  // a recording has ended
  unsupported,    // this machine or driver lacks what is needed
  device,         // a device or GL answered with an error
};

std::string_view name_of(FaultKind kind);

struct Fault {
  FaultKind kind;
  std::string message;  // for a person: what, where, which value, what was expected
};

template <class T = void>
using Result = tl::expected<T, Fault>;

inline tl::unexpected<Fault> fail(Fault fault) {
  return tl::unexpected<Fault>(std::move(fault));
}

// fail(FaultKind::bad_input, "{}: not a JPEG", path)
template <class... Args>
tl::unexpected<Fault> fail(FaultKind kind, fmt::format_string<Args...> format, Args&&... args) {
  return tl::unexpected<Fault>(Fault{kind, fmt::format(format, std::forward<Args>(args)...)});
}

// Collects all problems of an input, so that a person sees all of them together.
class Problems {
 public:
  template <class... Args>
  void add(fmt::format_string<Args...> format, Args&&... args) {
    lines_.push_back(fmt::format(format, std::forward<Args>(args)...));
  }
  bool empty() const { return lines_.empty(); }
  const std::vector<std::string>& lines() const { return lines_; }
  // One fault of kind bad_input with one problem per line.
  Fault fault() const;

 private:
  std::vector<std::string> lines_;
};

}  // namespace kasumi
