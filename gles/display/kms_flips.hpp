// The way of a picture to the glass, in three slots: pending (given to us), queued (the driver has it for its next
// refresh), active (shown). Nothing here waits without a deadline: a flip that does not complete is mended by setting
// the mode anew, once; if that does not help, the display is to be opened anew.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "base/clock.hpp"
#include "base/result.hpp"
#include "gles/display/display.hpp"
#include "gles/display/flip_record.hpp"
#include "gles/display/kms_device.hpp"
#include "gles/display/kms_scanout.hpp"

namespace kasumi {

struct KmsPicture {
  std::uint64_t number = 0;
  std::unique_ptr<ScanoutPicture> scanout;
  std::shared_ptr<const void> until_replaced;
};

class KmsFlips {
 public:
  // `atomic` false: the legacy calls. They are also taken to when the driver refuses the first atomic commit.
  KmsFlips(KmsDevice& device, const KmsPipe& pipe, bool atomic, Duration flip_deadline, Clock& clock)
      : device_(device), pipe_(pipe), atomic_(atomic), flip_deadline_(flip_deadline), clock_(clock) {}

  // BLOCKS until no picture is on its way, or the deadline passes. Errors: timeout, disconnected, device.
  Result<> settle(Instant deadline);
  // Sends a picture on its way; none is (settle answered well). Errors: disconnected, device.
  Result<> submit(KmsPicture picture);
  // What has happened by now. Does not block. Errors: as submit().
  Result<> advance();
  // BLOCKS until the display sleeps; the next picture wakes it. None is on its way. Errors: unsupported, and as
  // submit().
  Result<> turn_off();
  // The next picture sets the mode again.
  void set_mode_again() { sets_mode_ = true; }

  bool atomic() const { return atomic_; }
  bool is_settled() const { return !pending_ && !queued_; }
  bool is_well() const { return shown_once_ && !mending_; }  // the CRTC is ours and does as it is told
  std::vector<Flip> take_flips() { return record_.take(); }
  DisplayCounts counts() const { return {record_.count(), flip_timeouts_, modesets_}; }

 private:
  Result<> take_events(Duration at_most);
  Result<> commit();
  KmsResult<> hand_over(const KmsFrame& frame);
  Result<> refused(const KmsError& error);
  Result<> mend_what_is_overdue();
  void complete(std::optional<KmsPicture>& picture, Instant at);

  KmsDevice& device_;
  KmsPipe pipe_;
  bool atomic_;
  Duration flip_deadline_;
  Clock& clock_;

  std::optional<KmsPicture> pending_;
  std::optional<KmsPicture> queued_;
  std::optional<KmsPicture> active_;
  Instant given_at_{};       // to us, or to the driver, or when mending began; a flip is overdue by it
  Instant sent_at_{};        // to us
  bool sets_mode_ = true;    // the next commit sets the mode
  bool shown_once_ = false;  // the CRTC is ours
  bool mending_ = false;     // since the last flip that completed the mode was set anew

  FlipRecord record_;
  std::uint64_t flip_timeouts_ = 0;
  std::uint64_t modesets_ = 0;
};

}  // namespace kasumi
