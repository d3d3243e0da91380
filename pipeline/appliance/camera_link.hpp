// One live camera as its loop sees it: comes back by itself, its outages logged once each, its health told to others.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "pipeline/appliance/mailboxes.hpp"
#include "pipeline/machine/devices.hpp"

namespace kasumi {

// Belongs to one thread.
class CameraLink {
 public:
  CameraLink(CameraOpening opening, Clock& clock);
  // Lets go of the camera there was and takes this one.
  void replace(CameraOpening opening);

  // BLOCKS until a frame arrives or the deadline passes. Errors as ReconnectingSource.
  Result<Frame> next(Instant deadline);
  // The frame given last was none after all: it counts as bad.
  void reject(std::string_view reason) { source_->reject(reason); }
  CameraHealth health() const { return source_->health(); }
  std::uint64_t outages() const { return outages_; }
  bool recorded() const { return opening_.recorded; }
  CameraStatus status() const;

 private:
  void log_changes();

  Clock& clock_;
  CameraOpening opening_;
  std::unique_ptr<ReconnectingSource> source_;
  std::uint64_t outages_ = 0;
  bool lost_ = false;        // it was there and is gone
  bool waited_for_ = false;  // it has not been there yet, and that was said
  PictureCondition condition_ = PictureCondition::normal;
};

}  // namespace kasumi
