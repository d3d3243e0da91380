// The air by a fixture's two cameras, frame by frame.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>

#include "capture/fixture/replay_source.hpp"
#include "pipeline/lab/recording/air_curve.hpp"
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

// Empty: there are no more, or it is over.
using ReplayedFrame = std::optional<Result<Frame>>;

// Belongs to one thread at a time.
class ReplayedAir {
 public:
  explicit ReplayedAir(const Installation& installation);

  // Follows the sky up to the scene camera's next frame, and looks for the air in that; latest() is then the air that
  // it is drawn under.
  ReplayedFrame next_scene_frame(FixtureSources& sources, const std::function<bool()>& over);
  // The sky after the last frame, until `over`.
  void finish_sky(FixtureSources& sources, const std::function<bool()>& over);
  const SkyReport& latest() const { return latest_; }

  // The steps of it, where sky and scene play side by side: sight_due() is the scene's, the others are the sky's.
  std::optional<Sight> sight_due(const Result<Frame>& frame);  // once in a minute of recorded time
  void look(const Sight& sight, const DaylightState& above);
  std::optional<SkyReport> observe_sky(Result<Frame> frame);

  const TurbidityTable& table() const { return table_; }
  const AirCurve& curve() const { return curve_; }
  std::size_t sky_frames() const { return sky_frames_; }
  std::size_t usable_sky_frames() const { return usable_sky_frames_; }
  const std::map<std::string, std::size_t>& skipped() const { return skipped_; }  // frames of the sky by reason

 private:
  void take_sky_frame(Result<Frame> frame);
  void follow(SkyReport& report, Instant when) const;

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
};

}  // namespace kasumi
