// What visitors see, and why it is not the live picture: the words by which kiosk, status and reports tell it.
#pragma once

#include <optional>
#include <string_view>

namespace kasumi {

enum class Shown {
  live,      // the scene, with the building under today's air
  held,      // the last good picture, briefly
  degraded,  // the scene is live, but the air is out of date or the sun's position unknown
  still,     // the curated picture with its caption
  dark,      // closed, on purpose
  nothing,   // there is no display
};
inline constexpr Shown kAllShown[] = {Shown::live,  Shown::held, Shown::degraded,
                                      Shown::still, Shown::dark, Shown::nothing};
std::string_view name_of(Shown shown);
std::optional<Shown> shown_named(std::string_view name);

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
  content_refused,  // neither the configured content nor any that worked before can be shown
  no_display,
  stopped,  // by the service manager, or somebody
};
inline constexpr Trouble kAllTroubles[] = {Trouble::none,         Trouble::starting,        Trouble::scene_lost,
                                           Trouble::scene_frozen, Trouble::scene_covered,   Trouble::scene_white_out,
                                           Trouble::sky_lost,     Trouble::time_unknown,    Trouble::closed,
                                           Trouble::safe_mode,    Trouble::content_refused, Trouble::no_display,
                                           Trouble::stopped};
// A sentence, as status.json has it; empty for none.
std::string_view name_of(Trouble trouble);
std::optional<Trouble> trouble_named(std::string_view name);
// One word, for tables: "scene-lost"; "none".
std::string_view code_of(Trouble trouble);
std::optional<Trouble> trouble_coded(std::string_view code);

}  // namespace kasumi
