// A camera that reconnects by itself: opens, monitors, closes and reopens the source it is given.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "capture/camera_source.hpp"
#include "capture/frame_source.hpp"
#include "capture/picture_condition.hpp"

namespace kasumi {

// How to open a source repeatedly. `present`: whether its device is there now (its stable path exists), cheap enough to
// be called several times a second; empty: unknown. When it becomes true, the wait for the next attempt ends.
struct SourceOpener {
  std::string name;  // "scene camera"
  std::function<Result<std::unique_ptr<FrameSource>>()> open;
  std::function<bool()> present;
};

// For a recording, which keeps playing while it is not being read: each opening returns the same source, and it is
// present when it does not return `disconnected`.
SourceOpener reopening(std::string name, std::unique_ptr<FrameSource> source, Clock& clock);

struct ReconnectTimes {
  Duration first_frame_deadline = std::chrono::seconds(4);  // streaming started, but no frame arrives
  Duration stall_deadline = std::chrono::seconds(2);        // frames stop arriving; several frame intervals
  Duration bad_frames_deadline = std::chrono::seconds(10);  // frames arrive, but all are bad
  Duration first_backoff = std::chrono::seconds(1);         // 1, 2, 4 ..
  Duration longest_backoff =
      std::chrono::seconds(15);  // .. with jitter; restarts once the camera was up for longer than it waited
  double jitter = 0.2;           // fraction of the backoff, up or down
  std::uint64_t seed = 1;
  Duration condition_interval = std::chrono::seconds(1);   // between checks of the picture's condition
  Duration condition_deadline = std::chrono::seconds(30);  // how long frozen or covered until it is reported
};

// A camera's state and history.
struct CameraHealth {
  bool up = false;    // frames are arriving
  std::string cause;  // why not up: "unplugged", "stalled: no frame for 2.0 s", "first frame: none for 4.0 s", the
                      // driver's message; kept until frames arrive again
  std::optional<Instant> down_since;
  std::optional<Instant> last_good;  // by the host's clock, not the driver's
  PictureCondition condition = PictureCondition::normal;
  std::optional<FourCc> format;  // of the last good frame
  int width = 0;
  int height = 0;
  std::uint64_t good_frames = 0;
  std::map<std::string, std::uint64_t> bad_frames;  // by reason: "flagged", "truncated", or as given to reject()
  std::uint64_t opened = 0;
  std::map<std::string, std::uint64_t>
      reopened;                     // by cause: "unplugged", "stall", "first frame", "bad frames", "fatal"
  std::uint64_t sequence_gaps = 0;  // frames the driver dropped
  std::uint64_t skipped = 0;        // frames dropped in favour of newer ones because the reader was late
  std::uint64_t backwards = 0;      // timestamps that went backwards
  std::uint64_t mode_changes = 0;   // changes of size or format
  Duration last_outage{};           // duration of the last one
  std::optional<CameraMode> mode;   // as of the last opening, if the source is a CameraSource
  std::uint64_t frames_copied = 0;  // over all openings, if the source is a CameraSource
};

class ReconnectingSource : public FrameSource {
 public:
  // A snapshot as of the last call of next(). From any thread.
  virtual CameraHealth health() const = 0;
  // Reports that the last frame from next() could not be used (a damaged JPEG): it counts as bad for that reason
  // instead of as good. Call before the next call of next(), from the same thread.
  virtual void reject(std::string_view reason) = 0;
};

// next() returns good frames, and bad ones with their status (the reader keeps the last good picture). `disconnected`,
// with the cause as its message, whenever a source is closed, and once if the first attempt fails: the reader then
// releases all frames before it asks again. `timeout` while waiting for the camera to return; `end_of_stream` as the
// source returns it. A source is closed completely before another is opened. Nothing is opened before the first next().
// Frozen, covered and white pictures are reported in health(), and still delivered.
std::unique_ptr<ReconnectingSource> reconnecting(SourceOpener opener, Clock& clock, ReconnectTimes options = {});

}  // namespace kasumi
