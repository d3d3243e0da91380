#include "report/diagnosis/diagnosis.hpp"

#include <algorithm>
#include <optional>

namespace kasumi::report {

namespace {

// Then their being away is no fault of theirs.
bool leaves_cameras_alone(const ReportedStatus& told) {
  return told.values.is("start.safe_mode") || told.trouble == Trouble::content_refused;
}

Sight sight_of(const ReportedStatus& told) {
  if (!told.shown) return Sight::unknown;
  switch (*told.shown) {
    case Shown::live: return told.values.is("building_drawn") ? Sight::live : Sight::no_building;
    case Shown::held: return Sight::held;
    case Shown::degraded: return told.values.is("building_drawn") ? Sight::earlier_air : Sight::no_building;
    case Shown::still: return leaves_cameras_alone(told) ? Sight::out_of_order : Sight::still;
    case Shown::dark: return Sight::closed;
    case Shown::nothing: return Sight::nothing;
  }
  return Sight::unknown;
}

std::optional<Ill> ill_of(Trouble trouble) {
  switch (trouble) {
    case Trouble::starting: return Ill::starting;
    case Trouble::scene_lost: return Ill::scene_lost;
    case Trouble::scene_frozen: return Ill::scene_frozen;
    case Trouble::scene_covered: return Ill::scene_covered;
    case Trouble::scene_white_out: return Ill::scene_white_out;
    case Trouble::sky_lost: return Ill::sky_lost;
    case Trouble::time_unknown: return Ill::clock_unset;
    case Trouble::safe_mode: return Ill::safe_mode;
    case Trouble::content_refused: return Ill::content_refused;
    case Trouble::no_display: return Ill::no_display;
    case Trouble::none:
    case Trouble::stopped:
    case Trouble::closed: return std::nullopt;
  }
  return std::nullopt;
}

// Of a long list the first, which often has caused the others.
Symptom first_of(Ill ill, const std::vector<std::string>& lines, std::size_t in_all) {
  if (lines.empty()) return {ill, {}};
  return {ill, lines.front(), std::max(in_all, lines.size()) - 1};
}

std::string joined(const std::vector<std::string>& lines) {
  return fmt::format("{}", fmt::join(lines, "; "));
}

// Why the picture is not live, each in the kiosk's words where it has some.
std::string detail_of(Ill ill, const ReportedStatus& told) {
  switch (ill) {
    case Ill::scene_lost:
    case Ill::starting: return told.scene_camera.cause;
    case Ill::sky_lost: return told.sky_camera.cause;
    case Ill::no_display: return told.display_cause;
    case Ill::safe_mode: return joined(told.start_why);
    default: return {};
  }
}

void add_drift(const ReportedStatus& told, std::vector<Symptom>& symptoms) {
  std::vector<std::string> moved, soiled;
  for (const auto& drift : told.drifted)
    (drift.what == "dome" || drift.what == "focus" ? soiled : moved).push_back(drift.camera + ": " + drift.words);
  if (!moved.empty()) symptoms.push_back({Ill::camera_moved, joined(moved)});
  if (!soiled.empty()) symptoms.push_back({Ill::camera_soiled, joined(soiled)});
}

// Pictures come, and none can be shown: neither a cable nor a wait would help.
bool comes_in_another_size(const ReportedCamera& camera) {
  return !camera.values.is("up") && camera.cause.find(" instead of ") != std::string::npos;
}

// The picture's trouble is that none has come which could be drawn, and why is told by itself.
bool is_explained_by_drawing(Trouble trouble, const ReportedStatus& told) {
  const bool none_came = trouble == Trouble::starting || trouble == Trouble::scene_lost;
  return none_came && (comes_in_another_size(told.scene_camera) ||
                       (told.scene_camera.values.is("up") && !told.draw_refused.empty()));
}

// A camera whose loop hangs is told to be gone, and that it hangs.
std::vector<std::string> other_hung_loops(const ReportedStatus& told) {
  auto loops = told.hung_loops;
  std::erase_if(loops, [&](const std::string& loop) {
    return (loop == "scene" && !told.scene_camera.values.is("up")) ||
           (loop == "sky" && !told.sky_camera.values.is("up"));
  });
  return loops;
}

std::vector<Symptom> symptoms_of(const ReportedStatus& told) {
  std::vector<Symptom> symptoms;
  const auto add_list = [&](Ill ill, const std::vector<std::string>& lines, std::size_t in_all) {
    const bool known = std::ranges::any_of(symptoms, [&](const Symptom& other) { return other.ill == ill; });
    if (!lines.empty() && !known) symptoms.push_back(first_of(ill, lines, in_all));
  };
  // Of a content that is refused again by a reload the newest words.
  const bool refused_again = !told.refused.empty() && !told.reload_problems.empty();
  const auto add_reload_problems = [&](Ill ill) { add_list(ill, told.reload_problems, told.reload_problems_in_all); };
  if (refused_again)
    add_reload_problems(Ill::content_refused);
  else
    add_list(Ill::content_refused, told.refused, told.refused_in_all);
  const auto add = [&](bool is_so, Ill ill, std::string detail) {
    const bool known = std::ranges::any_of(symptoms, [&](const Symptom& other) { return other.ill == ill; });
    if (is_so && !known) symptoms.push_back({ill, std::move(detail)});
  };
  if (told.trouble && !is_explained_by_drawing(*told.trouble, told))
    if (const auto ill = ill_of(*told.trouble)) add(true, *ill, detail_of(*ill, told));
  const bool by_night = told.shown == Shown::dark;
  add(told.values.is("start.safe_mode"), Ill::safe_mode, joined(told.start_why));
  // One that is not there yet is told as `starting`.
  const bool alone = leaves_cameras_alone(told);
  add(!told.draw_refused.empty(), Ill::cannot_draw, told.draw_refused);
  add(comes_in_another_size(told.scene_camera) && !alone, Ill::cannot_draw, told.scene_camera.cause);
  add(!told.scene_camera.values.is("up") && !alone && told.trouble != Trouble::starting &&
          !comes_in_another_size(told.scene_camera),
      Ill::scene_lost, told.scene_camera.cause);
  add(!told.values.is("display.up") && !by_night && !told.values.is("start.safe_mode"), Ill::no_display,
      told.display_cause);
  const auto hung = other_hung_loops(told);
  add(!hung.empty(), Ill::hung, joined(hung));
  add(!told.sky_camera.values.is("up") && !alone && told.trouble != Trouble::starting, Ill::sky_lost,
      told.sky_camera.cause);
  add(told.values.is_not("clock_trusted") && !alone, Ill::clock_unset, {});
  add(told.values["heat.pictures_share"].value_or(1.0) < 1.0 || told.values.is("heat.throttled"), Ill::hot,
      told.values["heat.celsius"] ? fmt::format("{:.0f} °C", *told.values["heat.celsius"]) : std::string());
  // Without the sun's place, or the sky camera, nobody can see the air: they are what is wrong.
  add(told.values.is("air.supposed") && told.sky_camera.values.is("up") && !told.values.is_not("clock_trusted"),
      Ill::air_supposed, told.sky_reason);
  add(told.values.is("visibility.finding") && !told.values.is_not("clock_trusted"), Ill::observers_disagree,
      told.visibility_words);
  add_drift(told, symptoms);
  if (!refused_again) add_reload_problems(Ill::reload_refused);
  std::ranges::stable_sort(symptoms, [](const Symptom& a, const Symptom& b) {
    return hides_the_picture(a.ill) && !hides_the_picture(b.ill);
  });
  return symptoms;
}

}  // namespace

std::string_view name_of(Sight sight) {
  switch (sight) {
    case Sight::live: return "live";
    case Sight::held: return "held";
    case Sight::earlier_air: return "earlier-air";
    case Sight::no_building: return "no-building";
    case Sight::still: return "still";
    case Sight::out_of_order: return "out-of-order";
    case Sight::closed: return "closed";
    case Sight::nothing: return "nothing";
    case Sight::stopped: return "stopped";
    case Sight::unknown: return "unknown";
  }
  return "unknown";
}

bool is_well(Sight sight) {
  return sight == Sight::live || sight == Sight::held || sight == Sight::earlier_air || sight == Sight::closed;
}

std::string_view name_of(Ill ill) {
  switch (ill) {
    case Ill::not_running: return "not-running";
    case Ill::silent: return "silent";
    case Ill::unreadable: return "unreadable";
    case Ill::no_display: return "no-display";
    case Ill::scene_lost: return "scene-lost";
    case Ill::scene_frozen: return "scene-frozen";
    case Ill::scene_covered: return "scene-covered";
    case Ill::scene_white_out: return "scene-white-out";
    case Ill::starting: return "starting";
    case Ill::safe_mode: return "safe-mode";
    case Ill::cannot_draw: return "cannot-draw";
    case Ill::sky_lost: return "sky-lost";
    case Ill::clock_unset: return "clock-unset";
    case Ill::air_supposed: return "air-supposed";
    case Ill::observers_disagree: return "observers-disagree";
    case Ill::camera_moved: return "camera-moved";
    case Ill::camera_soiled: return "camera-soiled";
    case Ill::hot: return "hot";
    case Ill::hung: return "hung";
    case Ill::content_refused: return "content-refused";
    case Ill::reload_refused: return "reload-refused";
  }
  return "unknown";
}

bool hides_the_picture(Ill ill) {
  switch (ill) {
    case Ill::not_running:
    case Ill::silent:
    case Ill::unreadable:
    case Ill::no_display:
    case Ill::scene_lost:
    case Ill::scene_frozen:
    case Ill::scene_covered:
    case Ill::scene_white_out:
    case Ill::starting:
    case Ill::safe_mode:
    case Ill::cannot_draw: return true;
    default: return false;
  }
}

std::string_view command_for(Ill ill) {
  switch (ill) {
    case Ill::not_running: return "systemctl status kasumi";
    case Ill::silent: return "journalctl -u kasumi -n 20";
    case Ill::unreadable: return "jq . /run/kasumi/status.json";
    case Ill::no_display: return "sudo kasumi doctor";
    case Ill::scene_lost: return "jq .scene_camera.cause /run/kasumi/status.json";
    case Ill::scene_frozen:
    case Ill::scene_covered:
    case Ill::scene_white_out: return "jq .scene_camera.condition /run/kasumi/status.json";
    case Ill::starting: return "journalctl -u kasumi -p warning -n 20";
    case Ill::safe_mode: return "jq .start.why /run/kasumi/status.json";
    case Ill::cannot_draw: return "jq .draw_refused /run/kasumi/status.json";
    case Ill::sky_lost: return "jq .sky_camera.cause /run/kasumi/status.json";
    case Ill::clock_unset: return "timedatectl";
    case Ill::air_supposed: return "jq '.sky_reason, .visibility.reason' /run/kasumi/status.json";
    case Ill::observers_disagree: return "jq .visibility.words /run/kasumi/status.json";
    case Ill::camera_moved:
    case Ill::camera_soiled: return "jq .check.findings /run/kasumi/status.json";
    case Ill::hot: return "jq .heat /run/kasumi/status.json";
    case Ill::hung: return "jq .loops /run/kasumi/status.json";
    case Ill::content_refused:
    case Ill::reload_refused: return "kasumi run --config /etc/kasumi/kasumi.toml --check";
  }
  return {};
}

Diagnosis diagnose(const Heard& heard) {
  Diagnosis diagnosis;
  switch (heard.contact) {
    case Contact::stopped: diagnosis.sight = Sight::stopped; return diagnosis;
    case Contact::absent: diagnosis.symptoms = {{Ill::not_running, {}}}; return diagnosis;
    case Contact::silent: diagnosis.symptoms = {{Ill::silent, heard.why}}; return diagnosis;
    case Contact::unreadable: diagnosis.symptoms = {{Ill::unreadable, heard.why}}; return diagnosis;
    case Contact::heard: break;
  }
  diagnosis.sight = sight_of(*heard.status);
  diagnosis.symptoms = symptoms_of(*heard.status);
  return diagnosis;
}

}  // namespace kasumi::report
