// What the render loop reports to the others of the pictures it shows: twice a second.
#pragma once

#include "pipeline/kiosk/appliance/status_mailbox.hpp"

namespace kasumi {

class RenderReport {
 public:
  RenderReport(Mailboxes& mailboxes, Instant now) : mailboxes_(mailboxes), minute_began_(now) {}

  LatencyWatch& latency() { return latency_; }
  bool is_due(Instant now) const;
  void hasten() { published_at_.reset(); }  // it is due at once
  // Completes the status with latency and counts, for the status loop and the one that proves the content.
  void publish(RenderStatus& status, Instant now);

 private:
  Mailboxes& mailboxes_;
  LatencyWatch latency_;
  std::optional<Instant> published_at_;
  Instant minute_began_;
};

}  // namespace kasumi
