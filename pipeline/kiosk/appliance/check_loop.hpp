// The daily check whether the cameras still match their calibration. It reports only and changes nothing.
#pragma once

#include <filesystem>
#include <optional>

#include "pipeline/install/camera_drift/drift.hpp"
#include "pipeline/install/camera_drift/drift_frames.hpp"
#include "pipeline/kiosk/appliance/mailboxes.hpp"

namespace kasumi {

class CheckLoop {
 public:
  CheckLoop(ContentPtr content, Clock& clock, Mailboxes& mailboxes);
  // Requests pictures from the cameras' loops and judges them once there are enough, which BLOCKS for seconds: run
  // it in a thread of its own. Returns when to be called again.
  Instant step();

 private:
  void take_pictures();
  void judge();
  void publish(std::string summary, std::optional<DriftReport> report, bool warn);

  ContentPtr content_;
  Clock& clock_;
  Mailboxes& mailboxes_;
  std::optional<DriftFrames> frames_;  // while gathering
  Instant due_{};                      // for the next pictures
  bool done_today_ = false;            // checked; reset the next day
  bool pictures_replaced_ = false;     // those that earlier versions kept
};

}  // namespace kasumi
