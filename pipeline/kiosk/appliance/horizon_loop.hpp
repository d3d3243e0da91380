// Measures the horizon's light about once a second, and computes what a layer is drawn under, beside the drawing: both
// take longer than a picture lasts.
#pragma once

#include <utility>

#include "pipeline/kiosk/appliance/mailboxes.hpp"
#include "pipeline/kiosk/start/remembered_ground.hpp"

namespace kasumi {

class HorizonLoop {
 public:
  HorizonLoop(ContentPtr content, Clock& clock, Mailboxes& mailboxes)
      : content_(std::move(content)), clock_(clock), mailboxes_(mailboxes), keeper_(clock) {}

  // BLOCKS while it measures and computes. Returns when to be called again unless the bell rings before.
  Instant step() {
    auto& mailbox = mailboxes_.horizon;
    mailbox.pulse.turn(clock_.now(), kComputingBound);
    if (const auto content = mailbox.content.take()) content_ = *content;
    if (const auto question = mailbox.question.take()) {
      const auto& folder = content_->config.state_folder;
      if (question->ground) keeper_.recall(question->ground->watch, folder);
      mailboxes_.render.horizon.put(answer(*question));
      keeper_.keep(folder);
    }
    if (const auto question = mailbox.layer_question.take()) mailboxes_.render.layer.put(answer(*question));
    return clock_.now() + std::chrono::seconds(1);
  }

 private:
  ContentPtr content_;
  Clock& clock_;
  Mailboxes& mailboxes_;
  GroundKeeper keeper_;
};

}  // namespace kasumi
