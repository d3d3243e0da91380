// Visibility from landmarks: about once a minute, compares the air in the scene camera's picture with the sky camera's
// T. It reports only and changes nothing.
#pragma once

#include <optional>

#include "estimator/landmarks/landmark_air.hpp"
#include "pipeline/appliance/status_mailbox.hpp"

namespace kasumi {

class VisibilityLoop {
 public:
  VisibilityLoop(ContentPtr content, Clock& clock, Mailboxes& mailboxes);
  // Requests a picture from the scene camera's loop and reads the landmarks once it has come, which BLOCKS for a
  // fraction of a second: for a low-priority thread. Returns when to be called again.
  Instant step();

 private:
  void adopt_content();
  void judge(const CheckPicture& picture);
  void learn(const std::vector<ContrastReading>& readings);
  void publish(VisibilityStatus status);

  ContentPtr content_;
  Clock& clock_;
  Mailboxes& mailboxes_;
  std::optional<LandmarkWatch> watch_;  // empty: no landmark has a distance
  SkyAir sky_;
  Instant due_{};
  std::optional<Instant> learnt_;
  bool save_failing_ = false;  // already logged
  int disagreements_ = 0;      // looks in a row that disagreed with the sky
  bool reported_ = false;      // that they disagree
};

}  // namespace kasumi
