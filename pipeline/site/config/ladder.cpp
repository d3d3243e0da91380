#include "pipeline/site/config/ladder.hpp"

#include <algorithm>

namespace kasumi {

LadderTimes patient_with(LadderTimes options, Duration frame_interval) {
  options.held = std::max(options.held, frame_interval * 5 / 2);
  options.late = std::max(options.late, frame_interval * 3 / 2);
  return options;
}

Trouble Ladder::scene_trouble(const LadderInput& input) const {
  if (!input.picture_age) return Trouble::starting;
  if (*input.picture_age >= options_.held - options_.fade) return Trouble::scene_lost;
  return input.bad_scene_picture.value_or(Trouble::none);
}

Shown Ladder::rung_for(Instant now, const LadderInput& input, Trouble trouble) {
  if (!input.open) return Shown::dark;
  if (trouble != Trouble::none) {
    well_since_.reset();
    return Shown::still;
  }
  if (!well_since_) well_since_ = now;
  // An unstable camera must not make the screen flicker; the first picture may appear at once.
  const bool from_still = rung_.shown == Shown::still && rung_.trouble != Trouble::starting;
  if (from_still && now - *well_since_ < options_.steady) return Shown::still;
  if (*input.picture_age > options_.late) return Shown::held;
  return input.sky_up && input.sun_known ? Shown::live : Shown::degraded;
}

Rung Ladder::step(Instant now, const LadderInput& input) {
  const auto trouble = scene_trouble(input);
  const auto shown = rung_for(now, input, trouble);
  const double moved =
      stepped_ && !input.unseen ? std::max(0.0, to_seconds(now - *stepped_) / to_seconds(options_.fade)) : 1.0;
  const auto towards = [&](double from, double to) { return from + std::clamp(to - from, -moved, moved); };

  // Before the first picture there is nothing to fade from: the still appears at once.
  rung_.still = trouble == Trouble::starting ? 1.0 : towards(rung_.still, shown == Shown::still ? 1.0 : 0.0);
  rung_.dark = towards(rung_.dark, shown == Shown::dark ? 1.0 : 0.0);
  // The message stays until the still goes.
  if (shown == Shown::dark)
    rung_.trouble = Trouble::closed;
  else if (trouble != Trouble::none)
    rung_.trouble = trouble;
  else if (shown != Shown::still)
    rung_.trouble = shown != Shown::degraded ? Trouble::none
                    : !input.sun_known       ? Trouble::time_unknown
                                             : Trouble::sky_lost;
  rung_.shown = shown;
  stepped_ = now;
  if (input.display || shown == Shown::dark) return rung_;
  // Fades and timeouts continue, so that a display that returns shows the right rung of the ladder.
  auto unseen = rung_;
  unseen.shown = Shown::nothing;
  unseen.trouble = Trouble::no_display;
  return unseen;
}

}  // namespace kasumi
