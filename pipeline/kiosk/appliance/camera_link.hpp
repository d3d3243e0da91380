// One live camera as its loop sees it: reconnects by itself, logs each outage once, reports its health.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "pipeline/kiosk/appliance/mailboxes.hpp"
#include "pipeline/machine/devices.hpp"

namespace kasumi {

// Belongs to one thread.
class CameraLink {
 public:
  CameraLink(CameraOpening opening, Clock& clock);
  // Releases the current camera and uses this one.
  void replace(CameraOpening opening);

  // BLOCKS until a frame arrives or the deadline passes. Errors as ReconnectingSource.
  Result<Frame> next(Instant deadline);
  // Counts the last frame as bad after all.
  void reject(std::string_view reason) { source_->reject(reason); }
  CameraHealth health() const { return source_->health(); }
  std::uint64_t outages() const { return outages_; }
  Duration frame_interval() const { return opening_.frame_interval; }  // 0: unknown
  bool recorded() const { return opening_.recorded; }
  CameraStatus status() const;

 private:
  void log_changes();

  Clock& clock_;
  CameraOpening opening_;
  std::unique_ptr<ReconnectingSource> source_;
  std::uint64_t outages_ = 0;
  bool lost_ = false;        // it worked before and is gone
  bool waited_for_ = false;  // it has never worked, and that was logged
  PictureCondition condition_ = PictureCondition::normal;
};

}  // namespace kasumi
