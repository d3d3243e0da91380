#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "base/outside/json_depth.hpp"
#include "base/outside/json_text.hpp"
#include "base/utc_text.hpp"
#include "pipeline/kiosk/doctor/checks.hpp"

namespace kasumi {

namespace {

using Json = nlohmann::json;

constexpr double kStale_s = 5.0;  // it is written once a second

// Another version may have written the file, so any key may be missing.
double number(const Json& json, const char* key) {
  return json.is_object() && json.contains(key) && json[key].is_number() ? json[key].get<double>() : 0.0;
}
std::string text(const Json& json, const char* key) {
  return json.is_object() && json.contains(key) && json[key].is_string() ? json[key].get<std::string>() : std::string();
}
bool flag(const Json& json, const char* key) {
  return json.is_object() && json.contains(key) && json[key].is_boolean() && json[key].get<bool>();
}
Json part(const Json& json, const char* key) {
  return json.is_object() && json.contains(key) ? json[key] : Json::object();
}
double sum(const Json& counts) {
  double total = 0.0;
  if (counts.is_object())
    for (const auto& [reason, count] : counts.items()) total += count.is_number() ? count.get<double>() : 0.0;
  return total;
}
std::string list_of(const Json& counts) {
  std::string text_list;
  for (const auto& [reason, count] : counts.items())
    text_list += fmt::format("{}{} {}", text_list.empty() ? "" : ", ", text_of_json(count), reason);
  return text_list;
}

// A list of texts, each on a line of its own.
std::string list_below(const Json& lines) {
  std::string below;
  if (lines.is_array())
    for (const auto& line : lines)
      if (line.is_string()) below += "\n" + line.get<std::string>();
  return below;
}

// Counts belong to the time of writing, not of reading.
std::optional<double> between(const Json& before, const Json& later) {
  const auto from = parse_utc(text(before, "utc")), to = parse_utc(text(later, "utc"));
  if (!from || !to || *to <= *from) return std::nullopt;
  return to_seconds(*to - *from);
}

void check_live_camera(const std::string& name, const CameraOptions& options, const Json& before, const Json& later,
                       double seconds, Findings& findings) {
  if (!flag(later, "up")) {
    findings.fail(name + ".open", "not available: " + text(later, "cause"),
                  "check cable, power, hub; the appliance reconnects by itself");
    return;
  }
  const auto mode = part(later, "mode");
  const auto who = mode.empty()
                       ? std::string()
                       : fmt::format("{} ({}, {}): ", text(mode, "card"), text(mode, "driver"), text(mode, "place"));
  const auto found =
      fmt::format("{}{} {:.0f}x{:.0f}", who, text(later, "format"), number(later, "width"), number(later, "height"));
  std::string notes;
  if (const auto driver_notes = part(mode, "notes"); driver_notes.is_array())
    for (const auto& note : driver_notes)
      if (note.is_string()) notes += (notes.empty() ? "" : "; ") + note.get<std::string>();
  if (notes.empty())
    findings.good(name + ".mode", found);
  else
    findings.warn(name + ".mode", found + "; differs from the request: " + notes,
                  "v4l2-ctl -d DEVICE --list-formats-ext and --list-ctrls list what it supports; configure that");

  const double rate = (number(later, "good_frames") - number(before, "good_frames")) / seconds;
  const auto* request = request_of(options);
  double asked = request ? request->frames_per_second : 0.0;
  if (asked == 0.0) asked = number(mode, "frames_per_second");
  const auto rates = asked > 0.0 ? fmt::format("{:.1f} frames a second of {:.4g}", rate, asked)
                                 : fmt::format("{:.1f} frames a second", rate);
  const bool slow = (0.8 * asked - rate) * seconds > 2.0;
  auto& rated =
      slow ? findings.warn(name + ".rate", rates,
                           "dark scenes make cameras slow (exposure_s); USB bandwidth; the machine's load (top)")
           : findings.good(name + ".rate", rates);
  rated.values = {{"frames_per_second", rate}, {"asked_frames_per_second", asked}};

  const auto bad = part(later, "bad_frames");
  const double bad_now = sum(bad) - sum(part(before, "bad_frames"));
  auto& frames = bad_now > 0 ? findings.warn(name + ".frames", list_of(bad) + " since the start, and still increasing",
                                             "cable, hub, interference; dmesg | tail")
                             : findings.good(name + ".frames",
                                             sum(bad) > 0 ? list_of(bad) + " since the start, none now" : "all intact");
  frames.values = {{"bad", sum(bad)}, {"bad_now", bad_now}};

  const auto reopened = part(later, "reopened");
  auto& outages = sum(reopened) > 0
                      ? findings.warn(name + ".outages", "since the start: " + list_of(reopened),
                                      "journalctl -u kasumi -p warning shows when; look for a loose cable")
                      : findings.good(name + ".outages", "none since the start");
  outages.values["reopened"] = sum(reopened);
  if (const auto condition = text(later, "condition"); !condition.empty() && condition != "normal")
    findings.fail(name + ".picture", condition,
                  "check the lens: covered, blinded, or a camera that repeats one picture");
}

void check_loops(const Json& status, Findings& findings) {
  const auto loops = part(status, "loops");
  if (!loops.is_object() || loops.empty()) return;  // written by an older version
  std::string hung;
  double longest_s = 0.0;
  for (const auto& [name, loop] : loops.items()) {
    const double silent_s = number(loop, "silent_s");
    if (flag(loop, "up") || silent_s == 0.0) continue;
    hung += fmt::format("{}{} loop, silent for {:.0f} s", hung.empty() ? "" : "; ", name, silent_s);
    longest_s = std::max(longest_s, silent_s);
  }
  auto& finding = hung.empty() ? findings.good("loops", "all turn")
                               : findings.fail("loops", "hung: " + hung,
                                               "a call into a driver or a disk does not return: dmesg | tail. For a "
                                               "camera: cable, hub, power; after 60 s the service is restarted");
  finding.values["longest_silence_s"] = longest_s;
}

void check_heat(const Json& status, Findings& findings) {
  const auto heat = part(status, "heat");
  const double share = number(heat, "pictures_share");
  if (share == 0.0) return;  // written by an older version
  const auto found = share >= 1.0
                         ? std::string("all pictures are shown")
                         : fmt::format("only {:.0f} % of the pictures are shown: {}{:.0f} degrees{}", 100.0 * share,
                                       text(heat, "zone").empty() ? "" : text(heat, "zone") + " ",
                                       number(heat, "celsius"), flag(heat, "throttled") ? ", throttled" : "");
  auto& finding = share >= 1.0 ? findings.good("heat", found)
                               : findings.warn("heat", found, "check fan, dust, sun on the case; a smaller mode");
  finding.values = {{"pictures_share", share}, {"spared", number(heat, "spared")}};
}

void check_live_display(const Json& before, const Json& later, bool closed, double seconds, Findings& findings) {
  if (!flag(later, "up")) {
    findings.fail("display.open", "no display: " + text(later, "cause"),
                  "is the screen on? cable? another program using it? the appliance reopens it by itself");
    return;
  }
  findings.good("display.open", text(later, "description"));
  if (const auto planes = text(later, "planes"); planes == "on")
    findings.good("display.planes", "the building lies on a plane of its own over the camera's picture");
  else if (!planes.empty())
    findings.good("display.planes", "the GPU composes each picture: " + planes);
  if (const auto mixing = text(later, "mixing"); !mixing.empty())
    findings.good("display.mixing",
                  fmt::format("the {} mixes each picture with the building's layer", mixing == "gpu" ? "GPU" : mixing));
  const double flips = (number(later, "flips") - number(before, "flips")) / seconds;
  const double timeouts = number(later, "flip_timeouts"), resets = number(later, "resets");
  const auto found = (closed ? std::string("closed") : fmt::format("{:.1f} pictures a second", flips)) +
                     fmt::format("; {:.0f} late flips, reopened {:.0f} times since the start", timeouts, resets);
  auto& finding =
      flips <= 0.0 && !closed
          ? findings.fail("display.flips", found, "journalctl -u kasumi -p warning; sudo systemctl restart kasumi")
      : timeouts > 0 ? findings.warn("display.flips", found, "cable and converter; dmesg | grep drm")
                     : findings.good("display.flips", found);
  finding.values = {{"flips_per_second", flips}, {"flip_timeouts", timeouts}, {"resets", resets}};
}

void check_live_air(const Json& status, Findings& findings) {
  const auto air = part(status, "air");
  const bool known = status.is_object() && status.contains("turbidity") && status["turbidity"].is_number();
  const auto turbidity = fmt::format("turbidity {:.2f} +- {:.2f}, {:.0f} s old", number(status, "turbidity"),
                                     number(status, "sigma"), number(status, "turbidity_age_s"));
  const auto state = text(air, "text");
  const auto found = known ? turbidity + (state.empty() ? "" : "; " + state) : state;
  if (text(status, "shown") == "dark")  // it is not shown, and by night unknowable
    findings.good("air", found.empty() ? "unknown, and not needed while closed" : found + " (closed)");
  else if (flag(air, "supposed"))
    findings.warn(
        "air", found,
        "clear sky for a while, or landmarks of known distance (docs/operating.md): " + text(status, "sky_reason"));
  else if (known)
    findings.good("air", found).values = {{"turbidity", number(status, "turbidity")},
                                          {"age_s", number(status, "turbidity_age_s")}};
  else
    findings.warn("air", "unknown yet: " + text(status, "sky_reason"),
                  "the sky must be clear enough for a while; kasumi estimate");
  const auto visibility = part(status, "visibility");
  if (flag(visibility, "finding"))
    findings.warn(
        "air.observers", text(visibility, "words"),
        "which is right? clean the sky camera's dome, look at the landmarks' boxes (kasumi replay --overlay)");
}

constexpr double kContradicts_sigmas = 3.0;  // of what landmarks have taught

// Whether the colours of landmarks fade as the scene camera is said to show them.
void check_saturation(const Installation& installation, const Json& status, Findings& findings) {
  constexpr double kVisible = 0.1;  // of the logarithm: a tenth more colour
  const auto visibility = part(status, "visibility");
  const double saturation = number(visibility, "saturation"), sigma = number(visibility, "saturation_sigma");
  if (!(saturation > 0.0) || !(sigma > 0.0)) return;
  auto found = fmt::format("landmarks lose colours as under a saturation of {:.2f} +- {:.2f}", saturation, sigma);
  const auto given = installation.given_saturation();
  if (given) found += fmt::format("; it is given as {:.2f}", *given);
  const double off = given ? std::abs(std::log(saturation / *given)) : 0.0;
  auto& finding = off > kVisible && off > kContradicts_sigmas * sigma / saturation
                      ? findings.warn("air.saturation", found,
                                      "scene.saturation, or another calibration of the scene camera's colours and "
                                      "response (docs/cameras.md)")
                      : findings.good("air.saturation", found);
  finding.values = {{"saturation", saturation}, {"sigma", sigma}};
}

// Whether landmarks fade as they do under the scene camera's response.
void check_tone(const Installation& installation, const Json& status, Findings& findings) {
  constexpr double kVisible = 0.1;  // of the exponent: some three steps of 255
  const auto visibility = part(status, "visibility");
  const double exponent = number(visibility, "tone_exponent"), sigma = number(visibility, "tone_exponent_sigma");
  if (!(exponent > 0.0) || !(sigma > 0.0)) return;
  const auto found = fmt::format("landmarks fade as under a tone exponent of {:.2f} +- {:.2f}", exponent, sigma);
  const double off = std::abs(exponent - 1.0);
  // The key corrects a supposed response alone, beside what it corrects by already.
  const bool supposed = installation.scene_tone_exponent || installation.scene.response.kind() == Response::Kind::srgb;
  std::string advice = "kasumi calibrate response";
  if (supposed)
    advice += fmt::format("; where that cannot be done, tone_exponent = {:.2f} in [scene] (docs/cameras.md)",
                          exponent * installation.scene_tone_exponent.value_or(1.0));
  auto& finding = off > kContradicts_sigmas * sigma && off > kVisible
                      ? findings.warn("air.tone", found + ", which contradicts the scene camera's response", advice)
                      : findings.good("air.tone", found);
  finding.values = {{"tone_exponent", exponent}, {"sigma", sigma}};
}

// The model of the light is right to some 14 %: a larger deviation means that a card is not what it was taken for.
void check_cards(const Json& status, Findings& findings) {
  constexpr double kLeast = 0.7, kMost = 1.4;
  const auto cards = part(status, "cards");
  if (!cards.is_object() || !cards.contains("in_view")) return;
  const int in_view = static_cast<int>(number(cards, "in_view"));
  if (!cards.contains("age_s") || !cards["age_s"].is_number()) {
    findings.warn("air.cards", fmt::format("none of {} read since the start", in_view),
                  "is the horizon's sky in view, nothing burnt out? region_px of [[cards]] (docs/cameras.md)");
    return;
  }
  std::string told;
  bool far_off = false;
  for (const auto& [key, name] : {std::pair("sun", "sun"), std::pair("around", "sky and ground")}) {
    const auto factors = part(cards, key);
    const bool three = factors.is_array() && factors.size() == 3 &&
                       std::ranges::all_of(factors, [](const Json& factor) { return factor.is_number(); });
    if (!three) return;
    told += fmt::format("{}{} {:.2f} {:.2f} {:.2f}", told.empty() ? "" : ", ", name, factors[0].get<double>(),
                        factors[1].get<double>(), factors[2].get<double>());
    for (const auto& factor : factors) far_off |= factor.get<double>() < kLeast || factor.get<double>() > kMost;
  }
  told += fmt::format(" of the model's light; {:.0f} of {} cards read", number(cards, "read"), in_view);
  if (far_off)
    findings.warn("air.cards", told, "a card's reflectance or faces_deg, a shadow on it, something before it");
  else
    findings.good("air.cards", told);
}

}  // namespace

void check_appliance(const RunConfig& config, const RunningAppliance& before, const RunningAppliance& later,
                     double seconds, Findings& findings) {
  const auto was = parse_json(modest_json(before.status)), is = parse_json(modest_json(later.status));
  seconds = between(was, is).value_or(seconds);
  if (later.age_s > kStale_s) {
    findings.fail("service", fmt::format("pid {} has not written its status for {:.0f} s", later.pid, later.age_s),
                  "the watchdog restarts it if it hangs; else: disk full? journalctl -u kasumi");
  } else {
    const auto shown = text(is, "shown"), reason = text(is, "reason");
    const auto found = fmt::format("pid {} shows: {}{}{}", later.pid, shown, reason.empty() ? "" : ", ", reason);
    if (const auto start = part(is, "start"); flag(start, "safe_mode"))
      findings.fail("service", found + list_below(part(start, "why")),
                    "docs/operating.md, \"When starts fail\": mend the cause, then sudo systemctl restart kasumi");
    else if (shown == "live" || shown == "dark")
      findings.good("service", found);
    else
      findings.warn("service", found, "the checks below show why");
  }
  check_loops(is, findings);
  check_heat(is, findings);
  check_live_camera("scene_camera", config.scene_camera, part(was, "scene_camera"), part(is, "scene_camera"), seconds,
                    findings);
  check_live_camera("sky_camera", config.sky_camera, part(was, "sky_camera"), part(is, "sky_camera"), seconds,
                    findings);
  if (const auto refused = text(is, "draw_refused"); !refused.empty())
    findings.fail("display.picture", "the scene camera's pictures cannot be drawn: " + refused,
                  "another size in [scene] and [scene.camera], or another driver: kasumi run --config FILE --check");
  if (const auto people = part(is, "people_in_front"); people.is_object()) {
    const auto found = fmt::format("people before the building: {}, {:.0f} % of the scene known", text(people, "state"),
                                   100.0 * number(people, "known_share"));
    const auto reason = text(people, "reason");
    findings.good("people_in_front", reason.empty() ? found : found + ": " + reason);
  }
  check_live_display(part(was, "display"), part(is, "display"), text(is, "shown") == "dark", seconds, findings);

  if (const auto latency = part(is, "latency_ms"); part(latency, "median").is_number()) {
    auto& finding = findings.good("latency", fmt::format("capture to screen {:.0f} ms, 95 % within {:.0f} ms",
                                                         number(latency, "median"), number(latency, "p95")));
    finding.values = {{"median_ms", number(latency, "median")}, {"p95_ms", number(latency, "p95")}};
  }
  check_live_air(is, findings);
  check_cards(is, findings);
  check_saturation(config.installation, is, findings);
  check_tone(config.installation, is, findings);
  if (const auto check = part(is, "check"); check.is_object()) {
    const auto found = fmt::format("{} ({})", text(check, "summary"), text(check, "utc"));
    const auto well = part(check, "well");
    if (well.is_boolean() && !well.get<bool>())
      findings.warn("calibration.drift", found,
                    "docs/calibration.md, \"What has changed since\": realign the camera or calibrate it again");
    else
      findings.good("calibration.drift", found);
  }
  if (const auto television = part(is, "television"); television.is_object()) {
    const auto found = fmt::format("{}: wanted {}, it is {}", text(television, "adapter"), text(television, "wanted"),
                                   text(television, "power"));
    if (const auto problem = text(television, "problem"); !problem.empty())
      findings.warn("display.television", fmt::format("{}: {}", text(television, "adapter"), problem),
                    "does its menu allow CEC (Anynet+, Bravia Sync, Simplink, ...)? else [display] cec = \"off\"");
    else
      findings.good("display.television", found);
  }
  const auto content = part(is, "content");
  if (const auto problem = text(content, "era_problem"); !problem.empty())
    findings.warn("content.era", problem, "kasumi run --config FILE --check");
  if (const auto refused = part(content, "refused"); refused.is_array() && !refused.empty())
    findings.fail("content.refused",
                  "shown is what worked until " + text(content, "last_good_utc") +
                      "; the configured content is refused:" + list_below(refused),
                  "correct what is named; kasumi run --config FILE --check; then sudo systemctl reload kasumi");
  if (const auto problems = part(content, "problems"); problems.is_array() && !problems.empty())
    findings.warn("content.reload",
                  "the last reload was rejected, the old content is still in use: " + text_of_json(problems.front()),
                  "kasumi run --config FILE --check; then sudo systemctl reload kasumi");
}

}  // namespace kasumi
