#include "gles/display/kms_flips.hpp"

#include <algorithm>
#include <utility>

namespace kasumi {
namespace {

constexpr Duration kBusyPause = std::chrono::milliseconds(2);  // before retrying when the driver was busy
// A driver reports when scanout of the first line begins, slightly after the event, by the same clock except for
// rounding. Timestamps outside the time between sending the picture and now are replaced by now.
constexpr Duration kTimestampTolerance = std::chrono::milliseconds(50);

bool is_denied(std::errc code) {
  return code == std::errc::permission_denied || code == std::errc::operation_not_permitted;
}
bool is_gone(std::errc code) {
  return code == std::errc::no_such_device || code == std::errc::no_such_device_or_address;
}
bool is_temporary(std::errc code) {
  return code == std::errc::device_or_resource_busy || code == std::errc::interrupted ||
         code == std::errc::resource_unavailable_try_again;
}

}  // namespace

Result<> KmsFlips::settle(Instant deadline) {
  while (true) {
    if (auto advanced = advance(); !advanced) return advanced;
    if (!pending_ && !queued_) return {};
    const Instant now = clock_.now();
    if (now >= deadline)
      return fail(FaultKind::timeout, "the previous picture has been on its way to the display for {:.0f} ms",
                  1e3 * to_seconds(now - given_at_));
    Instant until = std::min(deadline, given_at_ + flip_deadline_);
    if (pending_) until = std::min(until, now + kBusyPause);
    if (auto taken = take_events(std::max(until - now, Duration::zero())); !taken) return taken;
  }
}

Result<> KmsFlips::submit(QueuedFlip picture) {
  pending_ = std::move(picture);
  given_at_ = sent_at_ = clock_.now();
  return commit();
}

Result<> KmsFlips::ready_for_planes() const {
  if (!atomic_) return fail(FaultKind::unsupported, "{} has no atomic commits", device_.path());
  if (overdue_) return fail(FaultKind::unsupported, "a picture on planes never reached the display");
  if (sets_mode_) return fail(FaultKind::timeout, "the display's mode is not set yet");
  return {};
}

Result<> KmsFlips::ask_for_planes(const std::vector<KmsPlaneState>& planes) {
  if (auto ready = ready_for_planes(); !ready) return ready;
  const auto asked = device_.commit_planes(pipe_, with_others_off(planes), 0, KmsTrial::only_ask);
  if (!asked) return fail(FaultKind::unsupported, "{}", asked.error().what);
  return {};
}

Result<> KmsFlips::submit_planes(QueuedFlip picture) {
  if (auto ready = ready_for_planes(); !ready) return ready;
  pending_ = std::move(picture);
  given_at_ = sent_at_ = clock_.now();
  return commit_planes();
}

std::vector<KmsPlaneState> KmsFlips::with_others_off(std::vector<KmsPlaneState> planes) const {
  for (const KmsPlaneState& before : planes_)
    if (std::ranges::find(planes, before.plane, &KmsPlaneState::plane) == planes.end())
      planes.push_back({.plane = before.plane});
  return planes;
}

Result<> KmsFlips::commit_planes() {
  const auto handed = device_.commit_planes(pipe_, with_others_off(pending_->planes), pending_->number, KmsTrial::no);
  if (handed) {
    planes_ = pending_->planes;
    given_at_ = clock_.now();
    queued_ = std::exchange(pending_, std::nullopt);
    return {};
  }
  const std::errc code = handed.error().code;
  if (is_temporary(code)) return {};
  pending_.reset();
  if (is_denied(code) || is_gone(code)) return refused(handed.error());
  return fail(FaultKind::unsupported, "{}", handed.error().what);
}

Result<> KmsFlips::advance() {
  if (auto taken = take_events(Duration::zero()); !taken) return taken;
  if (auto recovered = recover_overdue_flip(); !recovered) return recovered;
  if (!pending_) return {};
  if (pending_->planes.empty()) return commit();
  const auto committed = commit_planes();
  if (!committed && committed.error().kind != FaultKind::unsupported) return committed;
  return {};  // a refused one is skipped: the next submission reports it
}

Result<> KmsFlips::take_events(Duration at_most) {
  const auto events = device_.wait_events(at_most);
  if (!events) return refused(events.error());
  for (const KmsEvent& event : *events) {
    // The driver may still complete a flip that timed out, while its picture is pending again. Events with other
    // numbers are late ones of earlier flips that timed out.
    if (queued_ && queued_->number == event.number)
      complete(queued_, event.at);
    else if (pending_ && pending_->number == event.number)
      complete(pending_, event.at);
  }
  return {};
}

void KmsFlips::complete(std::optional<QueuedFlip>& picture, Instant at) {
  const Instant now = clock_.now();
  const bool believed = at >= sent_at_ - kTimestampTolerance && at <= now + kTimestampTolerance;
  record_.add(picture->number, believed ? at : now);
  std::optional<QueuedFlip> replaced = std::exchange(active_, std::exchange(picture, std::nullopt));
  overdue_.reset();
  recovering_ = false;
}

Result<> KmsFlips::recover_overdue_flip() {
  if (!pending_ && !queued_) return {};
  if (clock_.now() - given_at_ < flip_deadline_) return {};
  ++flip_timeouts_;
  if (recovering_)
    return fail(FaultKind::device, "{}: pictures no longer reach the display, even after setting its mode again",
                device_.path());
  recovering_ = true;
  sets_mode_ = true;
  given_at_ = clock_.now();
  if (queued_) pending_ = std::exchange(queued_, std::nullopt);
  if (!pending_->planes.empty()) overdue_ = std::exchange(pending_, std::nullopt);  // an ordinary one sets the mode
  return {};
}

KmsResult<> KmsFlips::hand_over(const KmsFrame& frame) {
  if (atomic_ && sets_mode_)
    // Later modesets do not wait, because a stuck driver could block indefinitely.
    return device_.commit_mode(pipe_, frame, shown_once_ ? KmsWait::no : KmsWait::for_the_hardware);
  if (atomic_ && !planes_.empty()) {
    const KmsPlaneState whole{pipe_.plane, frame.framebuffer, {0, 0, pipe_.mode.width, pipe_.mode.height}};
    return device_.commit_planes(pipe_, with_others_off({whole}), frame.number, KmsTrial::no);
  }
  if (atomic_) return device_.commit_flip(pipe_, frame);
  if (sets_mode_) return device_.set_crtc(pipe_, frame);
  return device_.page_flip(pipe_, frame);
}

Result<> KmsFlips::commit() {
  while (true) {
    const bool setting_mode = sets_mode_;
    const auto handed = hand_over({pending_->scanout->framebuffer(), pending_->number});
    if (handed) {
      sets_mode_ = false;
      planes_.clear();
      shown_once_ = true;
      given_at_ = clock_.now();  // setting a mode can take the driver long
      if (setting_mode) ++modesets_;
      if (setting_mode && !atomic_)
        complete(pending_, clock_.now());  // set_crtc sends no event
      else
        queued_ = std::exchange(pending_, std::nullopt);
      return {};
    }
    const std::errc code = handed.error().code;
    if (is_temporary(code)) return {};  // stays pending until it is overdue
    if (is_denied(code) || is_gone(code)) return refused(handed.error());
    if (setting_mode && atomic_ && !shown_once_) {
      atomic_ = false;  // the driver offers atomic commits but refuses them
      continue;
    }
    if (!setting_mode && !recovering_) {
      recovering_ = true;
      sets_mode_ = true;  // another process may have turned the CRTC off or changed it
      continue;
    }
    return refused(handed.error());
  }
}

Result<> KmsFlips::turn_off() {
  if (!shown_once_) return fail(FaultKind::unsupported, "{}: the display has not been set up yet", device_.path());
  if (const auto off = device_.turn_off(pipe_, atomic_); !off) {
    const auto code = off.error().code;
    if (is_temporary(code)) return fail(FaultKind::timeout, "{}", off.error().what);
    if (is_denied(code) || is_gone(code)) return refused(off.error());
    return fail(FaultKind::unsupported, "{}", off.error().what);
  }
  sets_mode_ = true;
  return {};
}

Result<> KmsFlips::refused(const KmsError& error) {
  if (is_gone(error.code)) return fail(FaultKind::disconnected, "{} (the card is gone)", error.what);
  if (is_denied(error.code)) return fail(FaultKind::device, "{} (another process became DRM master)", error.what);
  return fail(FaultKind::device, "{}", error.what);
}

}  // namespace kasumi
