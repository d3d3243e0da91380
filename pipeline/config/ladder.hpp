// What the visitor is shown when not all is well: live, held, degraded, still, dark. A pure state machine: input and
// the time in, the rung out.
#pragma once

#include <optional>
#include <string_view>

#include "base/clock.hpp"

namespace kasumi {

enum class Shown {
  live,      // the scene, with the building under today's air
  held,      // the last good picture, for a moment
  degraded,  // the scene is live, the air is an earlier hour's or not known
  still,     // the curated picture with its caption
  dark,      // closed: on purpose
};
std::string_view name_of(Shown shown);

// Why it is not `live`.
enum class Trouble {
  none,
  starting,         // no picture has come yet since the start
  scene_lost,       // no picture comes from the scene camera
  scene_frozen,     // always the same picture
  scene_covered,    // something lies over the lens
  scene_white_out,  // nothing but white
  sky_lost,         // no picture comes from the sky camera: the air is an earlier one
  time_unknown,     // the sun's place is not known, so there is no building
  closed,           // outside opening hours
};
std::string_view name_of(Trouble trouble);

struct LadderOptions {
  Duration held = std::chrono::seconds(2);           // the longest an old picture is shown
  Duration late = std::chrono::milliseconds(500);    // a picture older than that is called held
  Duration steady = std::chrono::milliseconds(500);  // so long must pictures come before the still goes
  Duration fade = std::chrono::milliseconds(400);
  friend bool operator==(const LadderOptions&, const LadderOptions&) = default;
};
// For a camera that takes its time between pictures: the same patience in pictures instead of seconds.
LadderOptions patient_with(LadderOptions options, Duration frame_interval);

// What the render loop sees now.
struct LadderInput {
  std::optional<Duration> picture_age;       // of the newest good scene picture; empty: there never was one
  std::optional<Trouble> bad_scene_picture;  // pictures come, but show nothing: frozen, covered, white-out
  bool sky_up = false;
  bool sun_known = false;
  bool open = true;
};

struct Rung {
  Shown shown = Shown::still;
  Trouble trouble = Trouble::starting;
  double still = 1.0;  // opacity of the still picture over the scene: moves during a fade
  double dark = 0.0;   // opacity of black over all
  friend bool operator==(const Rung&, const Rung&) = default;
};

class Ladder {
 public:
  explicit Ladder(LadderOptions options = {}) : options_(options) {}
  // The fade ends when the held time does: no picture is ever seen that is older than options.held. Calling it more or
  // less often leads to the same rungs.
  Rung step(Instant now, const LadderInput& input);
  // From now on by these; the rung stays.
  void adopt(const LadderOptions& options) { options_ = options; }

 private:
  Trouble scene_trouble(const LadderInput& input) const;
  Shown rung_for(Instant now, const LadderInput& input, Trouble trouble);

  LadderOptions options_;
  Rung rung_;
  std::optional<Instant> stepped_;
  std::optional<Instant> well_since_;  // pictures come again
};

}  // namespace kasumi
