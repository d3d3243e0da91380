// Measures the horizon's light about once a second, and computes what a layer is drawn under, beside the drawing: both
// take longer than a picture lasts.
#pragma once

#include "pipeline/appliance/mailboxes.hpp"

namespace kasumi {

class HorizonLoop {
 public:
  HorizonLoop(Clock& clock, Mailboxes& mailboxes) : clock_(clock), mailboxes_(mailboxes) {}

  // BLOCKS while it measures and computes. Returns when to be called again unless the bell rings before.
  Instant step() {
    auto& mailbox = mailboxes_.horizon;
    mailbox.pulse.turn(clock_.now(), kComputingBound);
    (void)mailbox.content.take();  // a question brings all that it needs
    if (const auto question = mailbox.question.take()) mailboxes_.render.horizon.put(answer(*question));
    if (const auto question = mailbox.layer_question.take()) mailboxes_.render.layer.put(answer(*question));
    return clock_.now() + std::chrono::seconds(1);
  }

 private:
  Clock& clock_;
  Mailboxes& mailboxes_;
};

}  // namespace kasumi
