// About once a minute, what the scene camera's picture says of the air: for the state of the air, which the sky's loop
// keeps, and compared with what the sky camera says alone.
#pragma once

#include <optional>

#include "pipeline/kiosk/appliance/status_mailbox.hpp"
#include "pipeline/show/scene/scene_watch.hpp"

namespace kasumi {

class VisibilityLoop {
 public:
  VisibilityLoop(ContentPtr content, Clock& clock, Mailboxes& mailboxes);
  // Requests a picture from the scene camera's loop and reads the landmarks once it has come, which BLOCKS for a
  // fraction of a second: for a low-priority thread. Returns when to be called again.
  Instant step();

 private:
  void adopt_content();
  void judge(const RequestedFrame& picture);
  void keep_what_was_learnt();
  void publish(VisibilityStatus status);

  ContentPtr content_;
  Clock& clock_;
  Mailboxes& mailboxes_;
  std::optional<SceneWatch> watch_;  // empty: a picture can say nothing
  ObservedTurbidity sky_;
  Instant due_{};
  bool save_failing_ = false;  // already logged
  int disagreements_ = 0;      // looks in a row that disagreed with the sky
  bool reported_ = false;      // that they disagree
  bool begun_ = false;         // what was learnt before is read in its own thread: a disk may hang
};

}  // namespace kasumi
