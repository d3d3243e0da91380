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

Result<> KmsFlips::submit(KmsPicture picture) {
  pending_ = std::move(picture);
  given_at_ = sent_at_ = clock_.now();
  return commit();
}

Result<> KmsFlips::advance() {
  if (auto taken = take_events(Duration::zero()); !taken) return taken;
  if (auto recovered = recover_overdue_flip(); !recovered) return recovered;
  if (pending_) return commit();
  return {};
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

void KmsFlips::complete(std::optional<KmsPicture>& picture, Instant at) {
  const Instant now = clock_.now();
  const bool believed = at >= sent_at_ - kTimestampTolerance && at <= now + kTimestampTolerance;
  record_.add(picture->number, believed ? at : now);
  std::optional<KmsPicture> replaced = std::exchange(active_, std::exchange(picture, std::nullopt));
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
  return {};
}

KmsResult<> KmsFlips::hand_over(const KmsFrame& frame) {
  if (atomic_ && sets_mode_)
    // Later modesets do not wait, because a stuck driver could block indefinitely.
    return device_.commit_mode(pipe_, frame, shown_once_ ? KmsWait::no : KmsWait::for_the_hardware);
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
