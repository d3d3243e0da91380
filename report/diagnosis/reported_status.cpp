#include "report/diagnosis/reported_status.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "base/outside/json_depth.hpp"
#include "base/outside/json_text.hpp"
#include "base/utc_text.hpp"

namespace kasumi::report {

namespace {

using Json = nlohmann::json;

// Characters that turn what follows around: a page or a terminal would show other words than are there.
constexpr std::string_view kTurningMarks[] = {"\u202a", "\u202b", "\u202c", "\u202d", "\u202e",
                                              "\u2066", "\u2067", "\u2068", "\u2069"};

// One line of at most kMostTextBytes whole characters.
std::string plain(const std::string& text) {
  auto end = std::min(text.size(), kMostTextBytes);
  while (end > 0 && end < text.size() && (static_cast<unsigned char>(text[end]) & 0xc0u) == 0x80u) --end;
  std::string line = text.substr(0, end);
  for (char& c : line)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  for (const auto mark : kTurningMarks)
    for (auto at = line.find(mark); at != std::string::npos; at = line.find(mark, at)) line.erase(at, mark.size());
  return line;
}

// A part of the status; missing parts have no keys.
class Part {
 public:
  explicit Part(const Json& json) : json_(json) {}

  Part part(std::string_view key) const {
    static const Json kNothing = Json::object();
    const auto* found = find(key);
    return Part(found && found->is_object() ? *found : kNothing);
  }
  std::optional<double> number(std::string_view key, const Believed& believed) const {
    const auto* found = find(key);
    if (!found || !found->is_number()) return std::nullopt;
    const double value = found->get<double>();
    if (!std::isfinite(value) || value < believed.lowest || value > believed.highest) return std::nullopt;
    return value;
  }
  std::optional<double> seconds(std::string_view key) const { return number(key, kSeconds); }
  std::optional<bool> flag(std::string_view key) const {
    const auto* found = find(key);
    return found && found->is_boolean() ? std::optional(found->get<bool>()) : std::nullopt;
  }
  bool is(std::string_view key) const { return flag(key).value_or(false); }
  std::string text(std::string_view key) const {
    const auto* found = find(key);
    return found && found->is_string() ? plain(found->get_ref<const std::string&>()) : std::string();
  }
  std::vector<std::string> texts(std::string_view key) const {
    std::vector<std::string> lines;
    for_each(key, [&](const Json& entry) {
      if (entry.is_string()) lines.push_back(plain(entry.get_ref<const std::string&>()));
    });
    return lines;
  }
  // How many there are: the kiosk's last line may count those that it leaves out (lines_of() in base).
  std::size_t count(std::string_view key) const {
    const auto* found = find(key);
    if (!found || !found->is_array() || found->empty()) return 0;
    const auto last = found->back().is_string() ? found->back().get<std::string>() : std::string();
    std::size_t more = 0;
    int length = 0;
    std::sscanf(last.c_str(), "and %8zu more%n", &more, &length);
    return length > 0 && static_cast<std::size_t>(length) == last.size() ? found->size() - 1 + more : found->size();
  }
  double sum(std::string_view key, const Believed& believed) const {
    double total = 0.0;
    const auto* found = find(key);
    if (!found || !found->is_object()) return total;
    for (const auto& [name, value] : found->items())
      if (value.is_number()) total += std::clamp(value.get<double>(), believed.lowest, believed.highest);
    return std::isfinite(total) ? total : 0.0;
  }
  // "heat.celsius"
  std::optional<double> figure(std::string_view key, const Believed& believed) const {
    if (const auto dot = key.find('.'); dot != std::string_view::npos)
      return part(key.substr(0, dot)).figure(key.substr(dot + 1), believed);
    switch (believed.kind) {
      case FigureKind::number: return number(key, believed);
      case FigureKind::flag: return flag(key);
      case FigureKind::is_so: return is(key) ? 1.0 : 0.0;
      case FigureKind::sum: return sum(key, believed);
    }
    return std::nullopt;
  }
  // The first entries of a list.
  template <class Do>
  void for_each(std::string_view key, Do act) const {
    const auto* found = find(key);
    if (!found || !found->is_array()) return;
    for (std::size_t i = 0; i < std::min(found->size(), kMostListed); ++i) act((*found)[i]);
  }
  const Json& json() const { return json_; }

 private:
  const Json* find(std::string_view key) const {
    if (!json_.is_object()) return nullptr;
    const auto found = json_.find(key);
    return found == json_.end() ? nullptr : &*found;
  }
  const Json& json_;
};

template <const auto& kFigures>
void read_figures(const Part& part, BelievedFigures<kFigures>& values) {
  for (std::size_t i = 0; i < std::size(kFigures); ++i) {
    const StatusFigure& figure = kFigures[i];
    values.at(i) = part.figure(figure.key, figure.believed);
    if (!values.at(i) && !figure.otherwise.empty()) values.at(i) = part.figure(figure.otherwise, figure.believed);
  }
}

ReportedCamera told_camera(const Part& part) {
  ReportedCamera camera;
  read_figures(part, camera.values);
  camera.cause = part.text("cause");
  camera.condition = part.text("condition");
  camera.format = part.text("format");
  return camera;
}

void tell_air(const Part& root, ReportedStatus& told) {
  told.aerosol = root.text("aerosol");
  told.air_text = root.part("air").text("text");
  told.sky = root.text("sky");
  told.sky_reason = root.text("sky_reason");
  const Part visibility = root.part("visibility");
  told.visibility_words = visibility.text("words");
}

void tell_content(const Part& root, ReportedStatus& told) {
  const Part content = root.part("content"), start = root.part("start"), check = root.part("check");
  told.reloaded_utc = content.text("reloaded_utc");
  told.last_good_utc = content.text("last_good_utc");
  told.refused = content.texts("refused");
  told.reload_problems = content.texts("problems");
  told.refused_in_all = content.count("refused");
  told.reload_problems_in_all = content.count("problems");
  const Part arrived = content.part("arrived");
  told.arrived = parse_utc(arrived.text("utc"));
  told.arrived_words = arrived.text("words");
  told.start_why = start.texts("why");
  told.check_utc = check.text("utc");
  check.for_each("findings", [&](const Json& entry) {
    const Part finding(entry);
    if (finding.text("state") == "drifted")
      told.drifted.push_back({finding.text("camera"), finding.text("what"), finding.text("words")});
  });
}

void tell_machine(const Part& root, ReportedStatus& told) {
  const Part loops = root.part("loops");
  told.display_cause = root.part("display").text("cause");
  for (const auto& [name, loop] : loops.json().items()) {
    const Part life(loop);
    if (life.is("up") || !life.seconds("silent_s") || told.hung_loops.size() == kMostListed) continue;
    told.hung_loops.push_back(plain(name));
  }
}

}  // namespace

Result<ReportedStatus> parse_status(std::string_view text) {
  if (text.size() > kMostStatusBytes)
    return fail(FaultKind::bad_input, "the status has {} bytes: expected at most {}", text.size(), kMostStatusBytes);
  if (json_depth(text) > kDeepestStatus)
    return fail(FaultKind::bad_input, "the status is nested more than {} deep", kDeepestStatus);
  const Json json = parse_json(text);
  if (!json.is_object()) return fail(FaultKind::bad_input, "the status is no JSON object");
  const Part root(json);
  ReportedStatus told;
  read_figures(root, told.values);
  told.shown = shown_named(root.text("shown"));
  told.reason = root.text("reason");
  told.trouble = trouble_named(told.reason);
  told.scene_camera = told_camera(root.part("scene_camera"));
  told.sky_camera = told_camera(root.part("sky_camera"));
  tell_air(root, told);
  tell_content(root, told);
  tell_machine(root, told);
  told.draw_refused = root.text("draw_refused");
  told.utc = parse_utc(root.text("utc"));
  told.since = parse_utc(root.text("since_utc"));
  told.boot = root.text("boot");
  return told;
}

}  // namespace kasumi::report
