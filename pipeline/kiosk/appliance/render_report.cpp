#include "pipeline/kiosk/appliance/render_report.hpp"

namespace kasumi {

namespace {

constexpr Duration kRenderStatusInterval = std::chrono::milliseconds(500);

}  // namespace

bool RenderReport::is_due(Instant now) const {
  return !published_at_ || now - *published_at_ >= kRenderStatusInterval;
}

void RenderReport::publish(RenderStatus& status, Instant now) {
  published_at_ = now;
  status.told = now;
  status.frames_dropped = mailboxes_.render.frames.dropped();
  status.latency = latency_.whole();
  if (now - minute_began_ >= std::chrono::minutes(1)) {
    minute_began_ = now;
    status.latency_minute = latency_.take_minute();
  }
  mailboxes_.proving.scene_pictures = status.scene_frames;
  mailboxes_.proving.closed = status.rung.shown == Shown::dark;
  mailboxes_.status->render.put(status);
}

}  // namespace kasumi
