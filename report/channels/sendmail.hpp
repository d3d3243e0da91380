// A mail handed to the machine's sendmail, which may hang, fail or say too much: nobody waits for it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <sys/types.h>

#include "base/clock.hpp"
#include "base/result.hpp"
#include "base/unique_fd.hpp"

namespace kasumi::report {

class Sendmail {
 public:
  // Longer, and it is killed with all it has started.
  static constexpr Duration kLongest = std::chrono::seconds(60);

  // Starts `command`, whose first word is a program's whole name; the mail is its input. Error (io): it cannot be
  // started.
  static Result<Sendmail> start(const std::vector<std::string>& command, std::string_view mail, Clock& clock);
  Sendmail(Sendmail&&) noexcept;
  Sendmail& operator=(Sendmail&&) = delete;
  ~Sendmail();

  // What came of it, once it is over. Never waits. Errors (io): exit code and last words, or that it hung.
  std::optional<Result<>> turn();

 private:
  Sendmail(pid_t pid, UniqueFd said, std::string program, Clock& clock)
      : pid_(pid), said_(std::move(said)), program_(std::move(program)), clock_(clock), began_(clock.now()) {}
  void listen();

  pid_t pid_ = -1;
  UniqueFd said_;
  std::string program_, words_;  // its last line
  Clock& clock_;
  Instant began_;
  bool killed_ = false;
};

}  // namespace kasumi::report
