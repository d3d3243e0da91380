// Asks the appliance for the small picture of its screen, over its socket, distrustfully.
#pragma once

#include <filesystem>
#include <string>

#include "base/socket/screen_answer.hpp"

namespace kasumi::report {

enum class ScreenOutcome {
  picture,
  wait,       // too soon after the last
  nothing,    // is on the glass
  off,        // the appliance has no socket: its configuration allows none, or it does not run
  no_answer,  // in time, or none that can be believed
};

struct ScreenReply {
  ScreenOutcome outcome = ScreenOutcome::off;
  ScreenAnswer answer{};
  std::string why{};  // there is no answer
};

class ScreenAsking {
 public:
  static constexpr Duration kAnswerDeadline = std::chrono::seconds(5);  // a slow GPU draws a picture within one

  ScreenAsking(std::filesystem::path socket, const Clock& clock) : socket_(std::move(socket)), clock_(clock) {}
  // BLOCKS for at most two deadlines, and within a minute after such a call not at all: then the answer is to wait.
  ScreenReply ask();

 private:
  std::filesystem::path socket_;
  const Clock& clock_;
  Instant next_ = Instant::min();
};

}  // namespace kasumi::report
