// A camera that comes back by itself: opens, watches, tears down and reopens whatever source it is given.
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

// How a source is opened, again and again. `present`: whether its device is there now, cheap enough to be asked several
// times a second (the stable path exists); empty: nobody knows. When it turns true the wait for the next try ends.
struct SourceOpener {
  std::string name;  // "scene camera"
  std::function<Result<std::unique_ptr<FrameSource>>()> open;
  std::function<bool()> present;
};

// For a recording: it plays on while nobody listens, so each opening is given the same source, and it is present when
// it does not answer `disconnected`.
SourceOpener reopening(std::string name, std::unique_ptr<FrameSource> source, Clock& clock);

struct ReconnectOptions {
  Duration first_frame_deadline = std::chrono::seconds(4);  // streaming started, nothing comes
  Duration stall_deadline = std::chrono::seconds(2);  // frames came, none comes any more; several times the interval
  Duration bad_frames_deadline = std::chrono::seconds(10);  // frames come, each of them bad
  Duration first_backoff = std::chrono::seconds(1);         // 1, 2, 4 ..
  Duration longest_backoff = std::chrono::seconds(15);  // .. and jitter; begins anew once up for longer than it waited
  double jitter = 0.2;                                  // of the backoff, up or down
  std::uint64_t seed = 1;
  Duration condition_interval = std::chrono::seconds(1);   // between looks at whether the picture is one
  Duration condition_deadline = std::chrono::seconds(30);  // so long frozen or covered until it is said
};

// A camera's life so far.
struct CameraHealth {
  bool up = false;    // frames come
  std::string cause;  // why not: "unplugged", "stalled: no frame for 2.0 s", "first frame: none for 4.0 s", the
                      // driver's words; kept until frames come again
  std::optional<Instant> down_since;
  std::optional<Instant> last_good;  // by the clock, not the driver's
  PictureCondition condition = PictureCondition::normal;
  std::optional<FourCc> format;  // of the last good frame
  int width = 0;
  int height = 0;
  std::uint64_t good_frames = 0;
  std::map<std::string, std::uint64_t> bad_frames;  // by reason: "flagged", "truncated", the reader's
  std::uint64_t opened = 0;
  std::map<std::string, std::uint64_t>
      reopened;                     // by cause: "unplugged", "stall", "first frame", "bad frames", "fatal"
  std::uint64_t sequence_gaps = 0;  // frames the driver dropped
  std::uint64_t skipped = 0;        // frames passed over for newer ones, because the reader came late
  std::uint64_t backwards = 0;      // timestamps that ran backwards
  std::uint64_t mode_changes = 0;   // size or format other than before
  Duration last_outage{};           // how long the last one took
  std::optional<CameraMode> mode;   // as the last opening found it, where the source is a CameraSource
  std::uint64_t frames_copied = 0;  // of all openings, where the source is a CameraSource
};

class ReconnectingSource : public FrameSource {
 public:
  // A copy as of the last call of next(). From any thread.
  virtual CameraHealth health() const = 0;
  // The frame that next() gave last was none after all (a damaged JPEG): counts as bad by that reason instead of as
  // good. Call it before the next call of next(), from the same thread.
  virtual void reject(std::string_view reason) = 0;
};

// next(): good frames, and bad ones with their status (the reader keeps the last good picture). `disconnected` whenever
// a source is torn down, and once when there is none to begin with, with the cause as its message: the reader lets go
// of every frame then, before it asks again. `timeout` while waiting for the camera to come back; `end_of_stream` as
// the source says it. A source is torn down whole before another is opened. Nothing is opened until next() is asked.
// Frozen, covered and white pictures are noticed, not withheld.
std::unique_ptr<ReconnectingSource> reconnecting(SourceOpener opener, Clock& clock, ReconnectOptions options = {});

}  // namespace kasumi
