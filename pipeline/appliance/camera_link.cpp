#include "pipeline/appliance/camera_link.hpp"

#include <algorithm>

#include <spdlog/spdlog.h>

namespace kasumi {

namespace {

// The deadlines are made for video; a slow camera gets the same tolerance in frames.
ReconnectOptions reconnect_options(Duration interval) {
  ReconnectOptions options;
  const auto at_least = [](Duration& deadline, Duration least) { deadline = std::max(deadline, least); };
  at_least(options.stall_deadline, interval * 5 / 2);
  at_least(options.first_frame_deadline, interval * 5 / 2);
  at_least(options.bad_frames_deadline, interval * 5);
  at_least(options.condition_deadline, interval * 5);
  return options;
}

}  // namespace

CameraLink::CameraLink(CameraOpening opening, Clock& clock)
    : clock_(clock),
      opening_(std::move(opening)),
      source_(reconnecting(opening_.opener, clock_, reconnect_options(opening_.frame_interval))) {}

void CameraLink::replace(CameraOpening opening) {
  source_.reset();  // a camera cannot be opened twice
  ++outages_;
  opening_ = std::move(opening);
  source_ = reconnecting(opening_.opener, clock_, reconnect_options(opening_.frame_interval));
  lost_ = waited_for_ = false;
  condition_ = PictureCondition::normal;
}

Result<Frame> CameraLink::next(Instant deadline) {
  auto frame = source_->next(deadline);
  if (!frame && frame.error().kind == FaultKind::disconnected) ++outages_;
  // Other faults may return immediately every time: without a pause this would spin.
  if (!frame && frame.error().kind != FaultKind::disconnected && frame.error().kind != FaultKind::timeout)
    clock_.sleep_until(deadline);
  log_changes();
  return frame;
}

void CameraLink::log_changes() {
  const auto health = source_->health();
  const auto& name = opening_.opener.name;
  if (health.up && (lost_ || waited_for_))
    spdlog::info("{}: {} after {:.1f} s", name, lost_ ? "back" : "connected", to_seconds(health.last_outage));
  if (health.up) lost_ = waited_for_ = false;
  if (!health.up && !lost_ && health.good_frames > 0) {
    spdlog::warn("{}: lost: {}", name, health.cause);
    lost_ = true;
  }
  if (!health.up && !waited_for_ && health.good_frames == 0 && !health.cause.empty()) {
    spdlog::warn("{}: not available yet: {}", name, health.cause);
    waited_for_ = true;
  }
  if (health.condition != condition_) {
    condition_ = health.condition;
    if (condition_ == PictureCondition::normal)
      spdlog::info("{}: picture normal again", name);
    else
      spdlog::warn("{}: picture is {}", name, name_of(condition_));
  }
}

CameraStatus CameraLink::status() const {
  return {source_->health(), outages_, opening_.frame_interval};
}

}  // namespace kasumi
