// The appliance's landmarks: about once a minute, what the scene camera says of the air beside the sky camera's T. It
// tells; it changes nothing.
#pragma once

#include <optional>

#include "estimator/landmarks/landmark_air.hpp"
#include "pipeline/appliance/status_mailbox.hpp"

namespace kasumi {

class VisibilityLoop {
 public:
  VisibilityLoop(ContentPtr content, Clock& clock, Mailboxes& mailboxes);
  // Asks the scene camera's loop for a picture, and once it has come, reads the landmarks, which BLOCKS for a fraction
  // of a second: in a thread behind all others. Returns when to be called again.
  Instant step();

 private:
  void adopt_content();
  void judge(const CheckPicture& picture);
  void learn(const std::vector<ContrastReading>& readings);
  void publish(VisibilityStatus status);

  ContentPtr content_;
  Clock& clock_;
  Mailboxes& mailboxes_;
  std::optional<LandmarkWatch> watch_;  // empty: no landmark says how far it is
  SkyAir sky_;
  Instant due_{};
  std::optional<Instant> learnt_;
  bool save_failing_ = false;  // and said
  int disagreements_ = 0;      // looks in a row that disagreed with the sky
  bool reported_ = false;      // that they do
};

}  // namespace kasumi
