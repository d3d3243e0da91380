// What visitors see when something is wrong: live, held, degraded, still, dark; nothing where there is no display. A pure state machine: inputs and time
// in, rung out.
#pragma once

#include <optional>

#include "base/clock.hpp"
#include "base/status/rung.hpp"

namespace kasumi {

struct LadderTimes {
  Duration held = std::chrono::seconds(2);           // the longest an old picture is shown
  Duration late = std::chrono::milliseconds(500);    // a picture older than that is called held
  Duration steady = std::chrono::milliseconds(500);  // pictures must come for so long before the still goes
  Duration fade = std::chrono::milliseconds(400);
  friend bool operator==(const LadderTimes&, const LadderTimes&) = default;
};
// For a slow camera: the same tolerance counted in frames instead of seconds.
LadderTimes patient_with(LadderTimes options, Duration frame_interval);

// What the render loop observes now.
struct LadderInput {
  std::optional<Duration> picture_age;       // of the newest good scene picture; empty: none yet
  std::optional<Trouble> bad_scene_picture;  // pictures come, but are useless: frozen, covered, white-out
  bool sky_up = false;
  bool sun_known = false;
  bool open = true;
  bool display = true;  // there is one
  bool unseen = false;  // nothing is on it yet: there is nothing to fade from
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
  explicit Ladder(LadderTimes options = {}) : options_(options) {}
  // The fade to the still ends when the held time does, so no picture older than options.held is ever seen. The result
  // does not depend on how often this is called.
  Rung step(Instant now, const LadderInput& input);
  // Uses these options from now on; the rung stays.
  void adopt(const LadderTimes& options) { options_ = options; }

 private:
  Trouble scene_trouble(const LadderInput& input) const;
  Shown rung_for(Instant now, const LadderInput& input, Trouble trouble);

  LadderTimes options_;
  Rung rung_;
  std::optional<Instant> stepped_;
  std::optional<Instant> well_since_;  // since when pictures come again
};

}  // namespace kasumi
