// The appliance's daily look at whether its cameras are still as they were calibrated. It tells; it changes nothing.
#pragma once

#include <filesystem>
#include <optional>

#include "pipeline/appliance/mailboxes.hpp"
#include "pipeline/camera_drift/drift.hpp"
#include "pipeline/camera_drift/drift_frames.hpp"

namespace kasumi {

class CheckLoop {
 public:
  CheckLoop(ContentPtr content, std::filesystem::path config_file, Clock& clock, Mailboxes& mailboxes);
  // Asks the cameras' loops for pictures, and once enough have come, judges them, which BLOCKS for seconds: in a thread
  // of its own. Returns when to be called again.
  Instant step();

 private:
  void take_pictures();
  void judge();
  void publish(std::string summary, std::optional<DriftReport> report, bool warn);

  ContentPtr content_;
  std::filesystem::path config_file_;
  Clock& clock_;
  Mailboxes& mailboxes_;
  std::optional<DriftFrames> frames_;  // while it gathers
  Instant due_{};                      // the next pictures
  bool done_today_ = false;            // for this day
};

}  // namespace kasumi
