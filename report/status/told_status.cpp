#include "report/status/told_status.hpp"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "base/outside/json_depth.hpp"
#include "base/utc_text.hpp"

namespace kasumi::report {

namespace {

using Json = nlohmann::json;

constexpr double kMostCounted = 9007199254740992.0;  // 2^53: counts beyond are not exact
constexpr double kLongest_s = 1e9;                   // 30 years

// One line of at most kMostTextBytes whole characters.
std::string plain(const std::string& text) {
  auto end = std::min(text.size(), kMostTextBytes);
  while (end > 0 && end < text.size() && (static_cast<unsigned char>(text[end]) & 0xc0u) == 0x80u) --end;
  std::string line = text.substr(0, end);
  for (char& c : line)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  return line;
}

// A part of the status; missing parts have no keys.
class Part {
 public:
  explicit Part(const Json& json) : json_(json) {}

  Part part(const char* key) const {
    static const Json kNothing = Json::object();
    const auto* found = find(key);
    return Part(found && found->is_object() ? *found : kNothing);
  }
  std::optional<double> number(const char* key, double lowest, double highest) const {
    const auto* found = find(key);
    if (!found || !found->is_number()) return std::nullopt;
    const double value = found->get<double>();
    if (!std::isfinite(value) || value < lowest || value > highest) return std::nullopt;
    return value;
  }
  std::optional<double> count(const char* key) const { return number(key, 0.0, kMostCounted); }
  std::optional<double> seconds(const char* key) const { return number(key, 0.0, kLongest_s); }
  std::optional<bool> flag(const char* key) const {
    const auto* found = find(key);
    return found && found->is_boolean() ? std::optional(found->get<bool>()) : std::nullopt;
  }
  bool is(const char* key) const { return flag(key).value_or(false); }
  std::string text(const char* key) const {
    const auto* found = find(key);
    return found && found->is_string() ? plain(found->get_ref<const std::string&>()) : std::string();
  }
  std::vector<std::string> texts(const char* key) const {
    std::vector<std::string> lines;
    for_each(key, [&](const Json& entry) {
      if (entry.is_string()) lines.push_back(plain(entry.get_ref<const std::string&>()));
    });
    return lines;
  }
  double sum(const char* key) const {
    double total = 0.0;
    const auto* found = find(key);
    if (!found || !found->is_object()) return total;
    for (const auto& [name, value] : found->items())
      if (value.is_number()) total += std::clamp(value.get<double>(), 0.0, kMostCounted);
    return std::isfinite(total) ? total : 0.0;
  }
  // The first entries of a list.
  template <class Do>
  void for_each(const char* key, Do act) const {
    const auto* found = find(key);
    if (!found || !found->is_array()) return;
    for (std::size_t i = 0; i < std::min(found->size(), kMostListed); ++i) act((*found)[i]);
  }
  const Json& json() const { return json_; }

 private:
  const Json* find(const char* key) const {
    if (!json_.is_object()) return nullptr;
    const auto found = json_.find(key);
    return found == json_.end() ? nullptr : &*found;
  }
  const Json& json_;
};

ToldCamera told_camera(const Part& part) {
  ToldCamera camera;
  camera.up = part.is("up");
  camera.cause = part.text("cause");
  camera.condition = part.text("condition");
  camera.format = part.text("format");
  camera.down_s = part.seconds("down_s");
  camera.last_good_age_s = part.seconds("last_good_age_s");
  camera.good_frames = part.count("good_frames");
  camera.sequence_gaps = part.count("sequence_gaps");
  camera.width_px = part.number("width", 1.0, 65536.0);
  camera.height_px = part.number("height", 1.0, 65536.0);
  camera.frames_per_second = part.part("mode").number("frames_per_second", 0.0, 10000.0);
  camera.bad_frames = part.sum("bad_frames");
  camera.reopened = part.sum("reopened");
  return camera;
}

void tell_air(const Part& root, ToldStatus& told) {
  const Part air = root.part("air");
  told.turbidity = root.number("turbidity", 0.0, 1000.0);
  told.sigma_turbidity = root.number("sigma", 0.0, 1000.0);
  told.turbidity_age_s = root.seconds("turbidity_age_s");
  told.aod_550 = root.number("aod_550", 0.0, 100.0);
  told.sigma_aod_550 = air.number("sigma_aod_550", 0.0, 100.0);
  told.angstrom_exponent = root.number("angstrom_exponent", -10.0, 10.0);
  told.aerosol = root.text("aerosol");
  told.air_text = air.text("text");
  told.air_supposed = air.flag("supposed");
  told.air_age_s = air.seconds("age_s");
  if (!told.air_age_s) told.air_age_s = told.turbidity_age_s;
  told.sky = root.text("sky");
  told.sky_reason = root.text("sky_reason");
  const Part visibility = root.part("visibility");
  told.visibility_m = visibility.number("visibility_m", 0.0, 1e7);
  told.sigma_visibility_m = visibility.number("sigma_m", 0.0, 1e7);
  told.visibility_bound = visibility.text("bound");
  told.visibility_words = visibility.text("words");
  told.observers_disagree = visibility.is("finding");
}

void tell_content(const Part& root, ToldStatus& told) {
  const Part content = root.part("content"), start = root.part("start"), check = root.part("check");
  told.reloaded_utc = content.text("reloaded_utc");
  told.last_good_utc = content.text("last_good_utc");
  told.refused = content.texts("refused");
  told.reload_problems = content.texts("problems");
  const Part arrived = content.part("arrived");
  told.arrived = parse_utc(arrived.text("utc"));
  told.arrived_words = arrived.text("words");
  told.safe_mode = start.is("safe_mode");
  told.failed_boots = start.count("failed_boots");
  told.start_why = start.texts("why");
  told.check_utc = check.text("utc");
  told.check_summary = check.text("summary");
  check.for_each("findings", [&](const Json& entry) {
    const Part finding(entry);
    if (finding.text("state") == "drifted")
      told.drifted.push_back({finding.text("camera"), finding.text("what"), finding.text("words")});
  });
}

void tell_machine(const Part& root, ToldStatus& told) {
  const Part display = root.part("display"), heat = root.part("heat"), loops = root.part("loops");
  told.display_up = display.is("up");
  told.display_cause = display.text("cause");
  told.flip_timeouts = display.count("flip_timeouts");
  told.display_resets = display.count("resets");
  told.pictures_share = heat.number("pictures_share", 0.0, 1.0);
  told.celsius = heat.number("celsius", -100.0, 300.0);
  told.throttled = heat.is("throttled");
  for (const auto& [name, loop] : loops.json().items()) {
    const Part life(loop);
    if (life.is("up") || !life.seconds("silent_s") || told.hung_loops.size() == kMostListed) continue;
    told.hung_loops.push_back(plain(name));
  }
}

}  // namespace

Result<ToldStatus> parse_status(std::string_view text) {
  if (text.size() > kMostStatusBytes)
    return fail(FaultKind::bad_input, "the status has {} bytes: expected at most {}", text.size(), kMostStatusBytes);
  if (json_depth(text) > kDeepestStatus)
    return fail(FaultKind::bad_input, "the status is nested more than {} deep", kDeepestStatus);
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) return fail(FaultKind::bad_input, "the status is no JSON object");
  const Part root(json);
  ToldStatus told;
  told.shown = shown_named(root.text("shown"));
  told.reason = root.text("reason");
  told.trouble = trouble_named(told.reason);
  told.scene_camera = told_camera(root.part("scene_camera"));
  told.sky_camera = told_camera(root.part("sky_camera"));
  tell_air(root, told);
  tell_content(root, told);
  tell_machine(root, told);
  const Part screen = root.part("screen_picture");
  told.screen_allowed = screen.flag("allowed");
  told.screen_pictures = screen.count("taken");
  told.clock_trusted = root.flag("clock_trusted");
  told.building_drawn = root.is("building_drawn");
  told.draw_refused = root.text("draw_refused");
  const Part latency = root.part("latency_ms_last_minute");
  told.latency_median_ms = latency.number("median", 0.0, 1e6);
  told.latency_95_ms = latency.number("p95", 0.0, 1e6);
  told.pictures = root.count("pictures");
  told.frames_dropped = root.count("frames_dropped");
  told.utc = parse_utc(root.text("utc"));
  told.since = parse_utc(root.text("since_utc"));
  told.boot = root.text("boot");
  told.since_boot_s = root.seconds("since_boot_s");
  told.pid = root.number("pid", 1.0, 4194304.0);
  return told;
}

}  // namespace kasumi::report
