// What is wrong with the kiosk, from what it tells: the symptoms of docs/operating.md.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "report/diagnosis/status_watch.hpp"

namespace kasumi::report {

// What visitors see.
enum class Sight {
  live,
  held,
  earlier_air,  // live, under the air as it was measured last
  no_building,  // live, but without the building
  still,
  out_of_order,  // the still picture of safe mode
  closed,
  nothing,  // there is no display
  stopped,  // lately, on purpose
  unknown,  // nobody tells
};
inline constexpr Sight kAllSights[] = {Sight::live,    Sight::held,         Sight::earlier_air, Sight::no_building,
                                       Sight::still,   Sight::out_of_order, Sight::closed,      Sight::nothing,
                                       Sight::stopped, Sight::unknown};
std::string_view name_of(Sight sight);
// The building's picture is on the screen, as it should be, or it is closed on purpose.
bool is_well(Sight sight);

enum class Ill {
  not_running,
  silent,
  unreadable,
  no_display,
  scene_lost,
  scene_frozen,
  scene_covered,
  scene_white_out,
  starting,
  safe_mode,
  cannot_draw,
  sky_lost,
  clock_unset,
  air_supposed,
  observers_disagree,
  camera_moved,
  camera_soiled,
  hot,
  hung,
  content_refused,
  reload_refused,
};
inline constexpr Ill kAllIlls[] = {Ill::not_running,   Ill::silent,          Ill::unreadable,
                                   Ill::no_display,    Ill::scene_lost,      Ill::scene_frozen,
                                   Ill::scene_covered, Ill::scene_white_out, Ill::starting,
                                   Ill::safe_mode,     Ill::cannot_draw,     Ill::sky_lost,
                                   Ill::clock_unset,   Ill::air_supposed,    Ill::observers_disagree,
                                   Ill::camera_moved,  Ill::camera_soiled,   Ill::hot,
                                   Ill::hung,          Ill::content_refused, Ill::reload_refused};
// "scene-lost", for metrics and messages.
std::string_view name_of(Ill ill);
// Visitors do not see the building's picture because of it; else somebody should look after it soon.
bool hides_the_picture(Ill ill);
// What to type on the kiosk to learn more.
std::string_view command_for(Ill ill);

struct Symptom {
  Ill ill;
  std::string detail;    // in the kiosk's own words, English; may be empty
  std::size_t more = 0;  // of the same kind, untold
};

struct Diagnosis {
  Sight sight = Sight::unknown;
  std::vector<Symptom> symptoms;  // the worst first
};

Diagnosis diagnose(const Heard& heard);

}  // namespace kasumi::report
