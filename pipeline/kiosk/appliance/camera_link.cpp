#include "pipeline/kiosk/appliance/camera_link.hpp"

#include <spdlog/spdlog.h>

namespace kasumi {

CameraLink::CameraLink(CameraOpening opening, Clock& clock)
    : clock_(clock), opening_(std::move(opening)), source_(reconnecting(opening_, clock_)) {}

void CameraLink::replace(CameraOpening opening) {
  source_.reset();  // a camera cannot be opened twice
  ++outages_;
  opening_ = std::move(opening);
  source_ = reconnecting(opening_, clock_);
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
  return {source_->health(), outages_, opening_.frame_interval, clock_.now()};
}

}  // namespace kasumi
