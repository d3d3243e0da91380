// What visitors see when something is wrong: live, held, degraded, still, dark; nothing where there is no display. A pure state machine: inputs and time
// in, rung out.
#pragma once

#include <optional>
#include <string_view>

#include "base/clock.hpp"

namespace kasumi {

enum class Shown {
  live,      // the scene, with the building under today's air
  held,      // the last good picture, briefly
  degraded,  // the scene is live, but the air is out of date or the sun's position unknown
  still,     // the curated picture with its caption
  dark,      // closed, on purpose
  nothing,   // there is no display
};
std::string_view name_of(Shown shown);

// Why it is not `live`.
enum class Trouble {
  none,
  starting,         // no picture has come yet since the start
  scene_lost,       // no picture comes from the scene camera
  scene_frozen,     // always the same picture
  scene_covered,    // something lies over the lens
  scene_white_out,  // overexposed: all white
  sky_lost,         // no picture comes from the sky camera: the last known air is used
  time_unknown,     // the sun's position is unknown, so no building is drawn
  closed,           // outside opening hours
  safe_mode,        // three boots came to nothing: neither cameras nor scene are tried
  no_display,
};
std::string_view name_of(Trouble trouble);

struct LadderOptions {
  Duration held = std::chrono::seconds(2);           // the longest an old picture is shown
  Duration late = std::chrono::milliseconds(500);    // a picture older than that is called held
  Duration steady = std::chrono::milliseconds(500);  // pictures must come for so long before the still goes
  Duration fade = std::chrono::milliseconds(400);
  friend bool operator==(const LadderOptions&, const LadderOptions&) = default;
};
// For a slow camera: the same tolerance counted in frames instead of seconds.
LadderOptions patient_with(LadderOptions options, Duration frame_interval);

// What the render loop observes now.
struct LadderInput {
  std::optional<Duration> picture_age;       // of the newest good scene picture; empty: none yet
  std::optional<Trouble> bad_scene_picture;  // pictures come, but are useless: frozen, covered, white-out
  bool sky_up = false;
  bool sun_known = false;
  bool open = true;
  bool display = true;  // there is one
};

struct Rung {
  Shown shown = Shown::still;
  Trouble trouble = Trouble::starting;
  double still = 1.0;  // opacity of the still picture over the scene: changes during a fade
  double dark = 0.0;   // opacity of black over all
  friend bool operator==(const Rung&, const Rung&) = default;
};

class Ladder {
 public:
  explicit Ladder(LadderOptions options = {}) : options_(options) {}
  // The fade to the still ends when the held time does, so no picture older than options.held is ever seen. The result
  // does not depend on how often this is called.
  Rung step(Instant now, const LadderInput& input);
  // Uses these options from now on; the rung stays.
  void adopt(const LadderOptions& options) { options_ = options; }

 private:
  Trouble scene_trouble(const LadderInput& input) const;
  Shown rung_for(Instant now, const LadderInput& input, Trouble trouble);

  LadderOptions options_;
  Rung rung_;
  std::optional<Instant> stepped_;
  std::optional<Instant> well_since_;  // since when pictures come again
};

}  // namespace kasumi
