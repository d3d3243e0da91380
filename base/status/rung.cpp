#include "base/status/rung.hpp"

namespace kasumi {

std::string_view name_of(Shown shown) {
  switch (shown) {
    case Shown::live: return "live";
    case Shown::held: return "held";
    case Shown::degraded: return "degraded";
    case Shown::still: return "still";
    case Shown::dark: return "dark";
    case Shown::nothing: return "nothing";
  }
  return "unknown";
}

std::string_view name_of(Trouble trouble) {
  switch (trouble) {
    case Trouble::none: return "";
    case Trouble::starting: return "starting: no picture from the scene camera yet";
    case Trouble::scene_lost: return "no picture from the scene camera";
    case Trouble::scene_frozen: return "the scene camera's picture is frozen";
    case Trouble::scene_covered: return "the scene camera is covered";
    case Trouble::scene_white_out: return "the scene camera sees nothing but white";
    case Trouble::sky_lost: return "no picture from the sky camera: the air is held";
    case Trouble::time_unknown: return "the time is not known: no sun, no building";
    case Trouble::closed: return "closed";
    case Trouble::safe_mode: return "safe mode: too many starts have failed";
    case Trouble::content_refused: return "the content is refused, and none is left that worked";
    case Trouble::no_display: return "no display";
    case Trouble::stopped: return "stopped";
  }
  return "unknown";
}

std::optional<Shown> shown_named(std::string_view name) {
  for (const Shown shown : kAllShown)
    if (name_of(shown) == name) return shown;
  return std::nullopt;
}

std::optional<Trouble> trouble_named(std::string_view name) {
  for (const Trouble trouble : kAllTroubles)
    if (name_of(trouble) == name) return trouble;
  return std::nullopt;
}

std::string_view code_of(Trouble trouble) {
  switch (trouble) {
    case Trouble::none: return "none";
    case Trouble::starting: return "starting";
    case Trouble::scene_lost: return "scene-lost";
    case Trouble::scene_frozen: return "scene-frozen";
    case Trouble::scene_covered: return "scene-covered";
    case Trouble::scene_white_out: return "scene-white-out";
    case Trouble::sky_lost: return "sky-lost";
    case Trouble::time_unknown: return "time-unknown";
    case Trouble::closed: return "closed";
    case Trouble::safe_mode: return "safe-mode";
    case Trouble::content_refused: return "content-refused";
    case Trouble::no_display: return "no-display";
    case Trouble::stopped: return "stopped";
  }
  return "unknown";
}

std::optional<Trouble> trouble_coded(std::string_view code) {
  for (const Trouble trouble : kAllTroubles)
    if (code_of(trouble) == code) return trouble;
  return std::nullopt;
}

}  // namespace kasumi
