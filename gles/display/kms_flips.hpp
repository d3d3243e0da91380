// Tracks pictures on their way to the screen in three slots: pending (submitted), queued (with the driver for its next
// refresh), active (shown). Every wait has a deadline. If a flip does not complete, the mode is set again, once; if
// that does not help, the display must be reopened.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "base/result.hpp"
#include "gles/display/display.hpp"
#include "gles/display/flip_record.hpp"
#include "gles/display/kms_device.hpp"
#include "gles/display/kms_scanout.hpp"

namespace kasumi {

struct QueuedFlip {
  std::uint64_t number = 0;
  std::unique_ptr<ScanoutPicture> scanout;  // null: it is on planes
  std::vector<KmsPlaneState> planes{};
  std::shared_ptr<const void> until_replaced;
};

class KmsFlips {
 public:
  // `atomic` false: the legacy calls, which are also used if the driver refuses the first atomic commit.
  KmsFlips(KmsDevice& device, const KmsPipe& pipe, bool atomic, Duration flip_deadline, Clock& clock)
      : device_(device), pipe_(pipe), atomic_(atomic), flip_deadline_(flip_deadline), clock_(clock) {}

  // BLOCKS until no picture is pending or queued, or the deadline passes. Errors: timeout, disconnected, device.
  Result<> settle(Instant deadline);
  // Sends a picture to the display. Requires that settle() succeeded. Errors: disconnected, device.
  Result<> submit(QueuedFlip picture);
  // Whether the driver would show it so. Errors: timeout (the mode is to be set first, by an ordinary picture),
  // unsupported (with the driver's reason).
  Result<> ask_for_planes(const std::vector<KmsPlaneState>& planes);
  // submit() for a picture on planes; planes that the one before used otherwise show nothing. Errors: also those of
  // ask_for_planes(); then the picture before stays.
  Result<> submit_planes(QueuedFlip picture);
  // Processes events and timeouts. Does not block. Errors: as submit().
  Result<> advance();
  // BLOCKS until the display sleeps; the next picture wakes it. Requires that no picture is pending or queued. Errors:
  // unsupported, and as submit().
  Result<> turn_off();
  // The next picture sets the mode again.
  void set_mode_again() { sets_mode_ = true; }

  bool atomic() const { return atomic_; }
  bool is_settled() const { return !pending_ && !queued_; }
  bool is_healthy() const { return shown_once_ && !recovering_; }  // the CRTC is set up and completes flips
  std::vector<Flip> take_flips() { return record_.take(); }
  DisplayCounts counts() const { return {record_.count(), flip_timeouts_, modesets_}; }

 private:
  Result<> take_events(Duration at_most);
  Result<> ready_for_planes() const;
  std::vector<KmsPlaneState> with_others_off(std::vector<KmsPlaneState> planes) const;
  Result<> commit();
  Result<> commit_planes();
  KmsResult<> hand_over(const KmsFrame& frame);
  Result<> refused(const KmsError& error);
  Result<> recover_overdue_flip();
  void complete(std::optional<QueuedFlip>& picture, Instant at);

  KmsDevice& device_;
  KmsPipe pipe_;
  bool atomic_;
  Duration flip_deadline_;
  Clock& clock_;

  std::optional<QueuedFlip> pending_;
  std::optional<QueuedFlip> queued_;
  std::optional<QueuedFlip> active_;
  std::optional<QueuedFlip> overdue_;  // on planes: the display may still read it
  std::vector<KmsPlaneState> planes_;  // as committed last; empty: by an ordinary picture
  Instant given_at_{};       // when submitted, given to the driver, or recovery began; the flip deadline counts from it
  Instant sent_at_{};        // when submitted
  bool sets_mode_ = true;    // the next commit sets the mode
  bool shown_once_ = false;  // the CRTC has been set up
  bool recovering_ = false;  // the mode was set again since the last completed flip

  FlipRecord record_;
  std::uint64_t flip_timeouts_ = 0;
  std::uint64_t modesets_ = 0;
};

}  // namespace kasumi
