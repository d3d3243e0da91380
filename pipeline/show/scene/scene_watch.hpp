// The scene camera's half of the state of the air: what one of its pictures says of the air before it.
#pragma once

#include <optional>
#include <string>

#include "estimator/fusion/air_observation.hpp"
#include "estimator/landmarks/channel_extinctions.hpp"
#include "pipeline/site/config/installation.hpp"

namespace kasumi {

constexpr Duration kSceneLookInterval = std::chrono::minutes(1);  // air changes in minutes

// What the sky camera knows of the moment.
struct DaylightState {
  std::optional<SunDirection> sun;  // where it is known
  SkyCondition sky = SkyCondition::unknown;
};

// For the tracker of the air.
struct TrackerReading {
  Instant when{};                        // the picture was taken
  std::optional<PathReading> path;       // by landmarks
  std::optional<ColumnReading> low_sky;  // above the horizon
  std::optional<double> saturation{};    // of the camera, by all pictures so far; empty: undetermined
  bool empty() const { return !path && !low_sky && !saturation; }
};

struct SceneLook {
  std::optional<ChannelExtinctions> landmarks;  // empty: not measured, and `reason` says why
  std::string reason;                           // for people; also what is doubtful
  TrackerReading air;
  bool learnt = false;  // the landmarks' contrasts were narrowed
};

// Belongs to one thread.
class SceneWatch {
 public:
  explicit SceneWatch(const Installation& installation);

  bool has_landmarks() const { return !landmarks_.landmarks().empty(); }
  // Whether a picture can say anything.
  bool any() const { return has_landmarks() || reads_low_sky_; }
  // Reads the low sky, and the landmarks, whose contrasts it learns once in half an hour: the light hardly changes
  // within it. BLOCKS for a fraction of a second. Under a low sun nothing is read.
  SceneLook look(const PictureView& picture, Instant when, const DaylightState& above);

  // What was learnt, to be kept over a restart.
  LandmarkWatch& landmarks() { return landmarks_; }
  // The contrasts were learnt at `when`, before this watch began.
  void has_learnt(Instant when);

 private:
  Camera camera_;
  ModelToFit sky_;
  bool reads_low_sky_;  // not where the air is given, or T alone is followed
  LandmarkWatch landmarks_;
  std::optional<Instant> learnt_;
  double first_day_ = 0.0;  // added to this process's days, so that they follow those of what was kept
};

}  // namespace kasumi
