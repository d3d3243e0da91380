#include "report/channels/metrics.hpp"

#include <charconv>
#include <string_view>
#include <utility>
#include <vector>

#include <sys/statvfs.h>
#include <unistd.h>

#include "base/files.hpp"
#include "base/status/status_figures.hpp"

namespace kasumi::report {

namespace {

// A value of a label, in its quotes.
std::string label_value(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '\\' || c == '"') quoted += '\\';
    quoted += c == '\n' ? ' ' : c;
  }
  return quoted + "\"";
}

class MetricsText {
 public:
  // A counter's name ends in "_total".
  void head(std::string_view name, std::string_view help) {
    name_ = name;
    const auto* type = name.ends_with("_total") ? "counter" : "gauge";
    text_ += fmt::format("# HELP kasumi_{0} {2}\n# TYPE kasumi_{0} {1}\n", name, type, help);
  }
  void value(double value) { text_ += fmt::format("kasumi_{} {}\n", name_, value); }
  using Labels = std::vector<std::pair<std::string_view, std::string_view>>;
  void value(const Labels& labels, double value) {
    std::string inner;
    for (const auto& [key, text] : labels)
      inner += fmt::format("{}{}={}", inner.empty() ? "" : ",", key, label_value(text));
    text_ += fmt::format("kasumi_{}{{{}}} {}\n", name_, inner, value);
  }
  void one(std::string_view name, const std::optional<double>& known, std::string_view help) {
    if (!known) return;
    head(name, help);
    value(*known);
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
  std::string_view name_;
};

std::optional<double> as_number(const std::optional<bool>& flag) {
  return flag ? std::optional(*flag ? 1.0 : 0.0) : std::nullopt;
}

void tell_cameras(const ReportedStatus& told, MetricsText& text) {
  for (std::size_t i = 0; i < std::size(kCameraFigures); ++i) {
    const auto& figure = kCameraFigures[i];
    if (figure.metric.empty()) continue;
    text.head(figure.metric, figure.what);
    for (const auto& [camera, of] : {std::pair{"scene", &told.scene_camera}, std::pair{"sky", &told.sky_camera}})
      if (const auto value = of->values.at(i)) text.value({{"camera", camera}}, *value / figure.shown.metric_unit);
  }
}

void tell_drift(const ReportedStatus& told, MetricsText& text) {
  if (told.check_utc.empty()) return;
  text.head("drifted", "What the last daily check found to have changed since the calibration.");
  static constexpr std::string_view kCameras[] = {"scene", "sky"};
  static constexpr std::string_view kWhat[] = {"view", "sun", "focus", "lens", "dome", "exposure"};
  for (const auto camera : kCameras)
    for (const auto what : kWhat) {
      double is = 0.0;
      for (const auto& drift : told.drifted)
        if (drift.camera == camera && drift.what == what) is = 1.0;
      text.value({{"camera", camera}, {"what", what}}, is);
    }
}

void tell_status(const ReportedStatus& told, MetricsText& text) {
  tell_cameras(told, text);
  for (const auto& figure : kStatusFigures)
    if (const auto value = told.values.of(figure.key); value && !figure.metric.empty())
      text.one(figure.metric, *value / figure.shown.metric_unit, figure.what);
  if (told.since)
    text.one("start_time_seconds", to_seconds(told.since->time_since_epoch()),
             "When the appliance started, Unix time.");
  tell_drift(told, text);
}

void tell_tries(const std::optional<OwnFigures::Tries>& tries, std::string_view name, std::string_view help,
                MetricsText& text) {
  if (!tries) return;
  text.head(name, help);
  text.value({{"outcome", "done"}}, static_cast<double>(tries->done));
  text.value({{"outcome", "failed"}}, static_cast<double>(tries->failed));
}

void tell_pulls(const std::optional<OwnFigures::Pulls>& pulls, MetricsText& text) {
  if (!pulls) return;
  text.head("report_content_pulls_total", "How often a web server was asked for content, by what came of it.");
  text.value({{"outcome", "came"}}, static_cast<double>(pulls->came));
  text.value({{"outcome", "unchanged"}}, static_cast<double>(pulls->unchanged));
  text.value({{"outcome", "failed"}}, static_cast<double>(pulls->failed));
}

}  // namespace

std::optional<DiskFigures> disk_figures(const std::string& folder) {
  struct statvfs disk {};
  if (folder.empty() || ::statvfs(folder.c_str(), &disk) != 0) return std::nullopt;
  const auto block = static_cast<double>(disk.f_frsize);
  return DiskFigures{static_cast<double>(disk.f_bavail) * block, static_cast<double>(disk.f_blocks) * block};
}

std::optional<double> own_resident_bytes() {
  const auto text = read_text_file("/proc/self/statm").value_or("");
  const auto space = text.find(' ');
  if (space == std::string::npos) return std::nullopt;
  double pages = 0.0;
  const auto parsed = std::from_chars(text.data() + space + 1, text.data() + text.size(), pages);
  if (parsed.ec != std::errc()) return std::nullopt;
  return pages * static_cast<double>(::sysconf(_SC_PAGESIZE));
}

std::string metrics_text(const Heard& heard, const std::optional<DiskFigures>& disk, const OwnFigures& own) {
  MetricsText text;
  const auto diagnosis = diagnose(heard);
  text.one("up", heard.contact == Contact::heard ? 1.0 : 0.0, "Whether the appliance tells its state.");
  text.one("picture_well", is_well(diagnosis.sight) ? 1.0 : 0.0,
           "Whether visitors see the building's picture, or it is closed on purpose.");
  text.head("sight", "What visitors see: 1 for what is so.");
  for (const Sight sight : kAllSights) text.value({{"sight", name_of(sight)}}, sight == diagnosis.sight ? 1.0 : 0.0);
  text.head("symptom", "What is wrong: 1 for what is so.");
  for (const Ill ill : kAllIlls) {
    double is = 0.0;
    for (const auto& symptom : diagnosis.symptoms)
      if (symptom.ill == ill) is = 1.0;
    text.value({{"symptom", name_of(ill)}}, is);
  }
  if (heard.status) tell_status(*heard.status, text);
  if (disk) {
    text.one("state_disk_free_bytes", disk->free_bytes, "Room left where the appliance keeps its state.");
    text.one("state_disk_size_bytes", disk->all_bytes, "Size of that disk.");
  }
  text.head("report_answers_total", "Answers to requests by status code.");
  for (const auto& [code, count] : own.answered) text.value({{"code", code}}, static_cast<double>(count));
  text.head("report_refused_total", "Peers that were refused or cut off, by reason.");
  for (const auto& [why, count] : own.refused) text.value({{"why", why}}, static_cast<double>(count));
  text.one("report_mqtt_connected", as_number(own.mqtt_connected), "Whether the MQTT broker takes what we tell.");
  tell_tries(own.mails, "report_mails_total", "Mails, by what came of them.", text);
  tell_tries(own.signs_of_life, "report_signs_of_life_total", "Signs of life, by what came of them.", text);
  tell_pulls(own.pulls, text);
  text.one("report_resident_memory_bytes", own.resident_bytes, "Memory of the reporter itself.");
  return text.text();
}

}  // namespace kasumi::report
