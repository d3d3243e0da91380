// A recorded camera that behaves like a live one.
#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "base/clock.hpp"
#include "base/result.hpp"
#include "capture/frame_source.hpp"

namespace kasumi {

// Ties recorded time to a clock. Shared by the sources of one fixture, so that sky and scene play in step. Thread-safe.
class ReplayTimeline {
 public:
  // `first`: the earliest recorded instant of all sources. `period`: after how long a loop begins anew.
  // `starts_at`: when `first` plays; when left out, the moment a source is first asked, so that time spent between
  // opening and playing does not make the first frames late.
  ReplayTimeline(Instant first, Duration period, std::optional<Instant> starts_at = std::nullopt)
      : first_(first), period_(period), starts_at_(starts_at) {}
  Instant on_clock(Instant recorded, const Clock& clock);
  Duration period() const { return period_; }

 private:
  Instant first_;
  Duration period_;
  std::mutex mutex_;
  std::optional<Instant> starts_at_;
};

struct ReplayOptions {
  // Begins anew for ever: captured_at and sequence run on, utc stays as recorded (the sky shows that sun).
  bool loop = false;
  std::optional<Instant> starts_at{};          // see ReplayTimeline
  std::shared_ptr<ReplayTimeline> timeline{};  // replaces starts_at; null: the source's own
};

// Delivers every row of the index, in the order of rows, as soon as clock.now() has reached its recorded instant on the
// timeline; late rows and rows whose timestamps run backwards come at once. Metadata is as recorded (`captured_at` is
// the recorder's clock); status is what judge() makes of the payload.
// Errors besides FrameSource's: io when a payload has become unreadable; the next call goes on with the next row.
//   timeout: a gap in the recording reaches beyond the deadline, or the clock was interrupted.
//   disconnected: from the instant of such a row until the next row's instant. The first call that meets it answers at
//   once, later ones wait for the deadline or the next row, so that a caller who only asks again gets on by any clock.
//
// Clocks. SystemClock: real time. ManualClock: next() waits until somebody turns it. UnhurriedClock: waiting takes no
// time. A source belongs to one thread; several threads may share the clock. On a shared UnhurriedClock each thread
// pulls time forward, so what is newest in one when the other draws depends on the scheduler, though every frame is
// delivered, in order. Who wants the same pictures each time plays both from one thread, always asking the source whose
// due() is earlier (the sky when equal).
class ReplaySource : public FrameSource {
 public:
  // When the next row is delivered, by the clock; empty at the end. Starts the timeline.
  virtual std::optional<Instant> due() = 0;
  virtual std::size_t row_count() const = 0;  // of one round, disconnects included
};

// `camera_folder` holds index.csv. Errors (bad_input): what read_index finds; no whole row.
Result<std::unique_ptr<ReplaySource>> open_replay(const std::filesystem::path& camera_folder, Clock& clock,
                                                  const ReplayOptions& options = {});

// Both cameras of a fixture on one timeline; the earlier of their first rows plays first.
struct FixtureSources {
  std::unique_ptr<ReplaySource> sky;
  std::unique_ptr<ReplaySource> scene;
};
// Errors (bad_input): the problems of both indexes.
Result<FixtureSources> open_fixture_sources(const std::filesystem::path& fixture_folder, Clock& clock,
                                            const ReplayOptions& options = {});

}  // namespace kasumi
