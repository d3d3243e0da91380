// The air by a fixture's two cameras, frame by frame.
#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <future>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "capture/fixture/replay_source.hpp"
#include "pipeline/lab/recording/air_curve.hpp"
#include "pipeline/lab/recording/stage_times.hpp"
#include "pipeline/lab/recording/turbidity_table.hpp"
#include "pipeline/lab/recording/turbidity_tracker.hpp"
#include "pipeline/show/scene/scene_watch.hpp"
#include "pipeline/show/scene/sky_watch.hpp"

namespace kasumi {

// A picture of the scene camera in which the air is looked for.
struct Sight {
  Instant when{};
  Utc utc{};
  Image<Rgb8> picture;
};

DaylightState above_in(const SkyReport& report);
// Until the sky camera's first picture comes, the frame's own time determines the sun, as the sky's will.
void place_sun(SkyReport& report, Utc utc, const Site& site);

// A frame of the scene camera with its picture, and the air that it is drawn under.
struct FrameUnderAir {
  Result<Frame> frame;
  Result<DecodedPicture> picture;  // only where there is a frame
  SkyReport sky;
};
// Empty: there are no more, or it is over.
using ReplayedFrame = std::optional<FrameUnderAir>;

// Belongs to one thread at a time. Frames ahead are decoded, and the sky's estimated, in threads of their own; what
// depends on the frames before is done in their order, so that timing changes nothing.
class ReplayedAir {
 public:
  // `times` must outlive it.
  ReplayedAir(const Installation& installation, StageTimes& times);

  // Follows the sky up to the scene camera's next frame, and looks for the air in that.
  ReplayedFrame next_scene_frame(FixtureSources& sources, const std::function<bool()>& over);
  // The sky after the last frame, until `over`.
  void finish_sky(FixtureSources& sources, const std::function<bool()>& over);
  const SkyReport& latest() const { return latest_; }

  // The steps of it, where sky and scene play side by side: sight_due() is the scene's, the others are the sky's.
  std::optional<Sight> sight_due(const Result<Frame>& frame);  // once in a minute of recorded time
  void look(const Sight& sight, const DaylightState& above);
  std::optional<SkyReport> observe_sky(const Result<Frame>& frame);

  const TurbidityTable& table() const { return table_; }
  const AirCurve& curve() const { return curve_; }
  std::size_t sky_frames() const { return sky_frames_; }
  std::size_t usable_sky_frames() const { return usable_sky_frames_; }
  const std::map<std::string, std::size_t>& skipped() const { return skipped_; }  // frames of the sky by reason

 private:
  // The next frame of either camera, which other threads are at work on.
  struct FrameAhead {
    Result<Frame> frame;
    bool of_sky = false;
    std::future<Result<SkyReport>> read{};          // of the sky's; not valid: there is no frame
    std::future<Result<DecodedPicture>> picture{};  // of the scene's, in the same way
  };
  void read_ahead(FixtureSources& sources);
  FrameAhead ahead_of_sky(Result<Frame> frame);
  FrameAhead ahead_of_scene(Result<Frame> frame);
  bool is_sight_due(const Result<Frame>& frame) const;
  std::optional<Sight> sight_of(const FrameMetadata& metadata, const Result<DecodedPicture>& picture);
  std::optional<SkyReport> observe_sky(const Result<Frame>& frame, Result<SkyReport> read);
  void take_sky_frame(FrameAhead ahead);
  void follow(SkyReport& report, Instant when) const;

  StageTimes& times_;
  Site site_;
  SkyWatch watch_;
  std::optional<TurbidityTracker> papers_;  // T alone, in the place of the watch's air; empty: sky_model says otherwise
  SceneWatch scene_watch_;
  YuvEncoding scene_encoding_;
  std::optional<Instant> looked_at_;
  TurbidityTable table_;
  AirCurve curve_;
  SkyReport latest_;
  std::size_t sky_frames_ = 0;
  std::size_t usable_sky_frames_ = 0;
  std::map<std::string, std::size_t> skipped_;
  std::vector<FrameReader> readers_;  // each for one frame at a time
  std::size_t next_reader_ = 0;
  std::deque<FrameAhead> ahead_;  // in the order of time, where the sky's goes first
  std::size_t sky_ahead_ = 0;     // of them; never more than readers
};

}  // namespace kasumi
