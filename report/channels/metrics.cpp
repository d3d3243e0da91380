#include "report/channels/metrics.hpp"

#include <charconv>
#include <string_view>
#include <utility>
#include <vector>

#include <sys/statvfs.h>
#include <unistd.h>

#include "base/files.hpp"

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
  void head(std::string_view name, std::string_view type, std::string_view help) {
    name_ = name;
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
  void gauge(std::string_view name, const std::optional<double>& known, std::string_view help) {
    if (!known) return;
    head(name, "gauge", help);
    value(*known);
  }
  void counter(std::string_view name, const std::optional<double>& known, std::string_view help) {
    if (!known) return;
    head(name, "counter", help);
    value(*known);
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
  std::string_view name_;
};

std::optional<double> in_seconds(const std::optional<double>& value_ms) {
  return value_ms ? std::optional(*value_ms / 1000.0) : std::nullopt;
}

std::optional<double> as_number(const std::optional<bool>& flag) {
  return flag ? std::optional(*flag ? 1.0 : 0.0) : std::nullopt;
}

void tell_cameras(const ToldStatus& told, MetricsText& text) {
  const std::pair<std::string_view, const ToldCamera*> cameras[] = {{"scene", &told.scene_camera},
                                                                    {"sky", &told.sky_camera}};
  const auto each = [&](std::string_view name, std::string_view type, std::string_view help, auto figure) {
    text.head(name, type, help);
    for (const auto& [camera, is] : cameras)
      if (const std::optional<double> value = figure(*is)) text.value({{"camera", camera}}, *value);
  };
  each("camera_up", "gauge", "Whether pictures come from the camera.",
       [](const ToldCamera& camera) { return camera.up ? 1.0 : 0.0; });
  each("camera_last_good_age_seconds", "gauge", "Since the camera's last good picture.",
       [](const ToldCamera& camera) { return camera.last_good_age_s; });
  each("camera_frames_total", "counter", "Good pictures since the start.",
       [](const ToldCamera& camera) { return camera.good_frames; });
  each("camera_bad_frames_total", "counter", "Damaged pictures since the start.",
       [](const ToldCamera& camera) { return camera.bad_frames; });
  each("camera_reopened_total", "counter", "How often the camera had to be opened again.",
       [](const ToldCamera& camera) { return camera.reopened; });
  each("camera_sequence_gaps_total", "counter", "Pictures that the driver dropped.",
       [](const ToldCamera& camera) { return camera.sequence_gaps; });
}

void tell_drift(const ToldStatus& told, MetricsText& text) {
  if (told.check_utc.empty()) return;
  text.head("drifted", "gauge", "What the last daily check found to have changed since the calibration.");
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

void tell_status(const ToldStatus& told, MetricsText& text) {
  tell_cameras(told, text);
  text.gauge("building_drawn", told.building_drawn ? 1.0 : 0.0, "Whether the building is in the picture.");
  text.gauge("display_up", told.display_up ? 1.0 : 0.0, "Whether there is a screen.");
  text.counter("display_flip_timeouts_total", told.flip_timeouts, "Pictures that the screen did not take in time.");
  text.counter("display_resets_total", told.display_resets, "How often the screen had to be opened again.");
  text.gauge("clock_trusted", as_number(told.clock_trusted), "Whether the machine's time is trusted.");
  text.gauge("turbidity", told.turbidity, "T of the air that drives the picture.");
  text.gauge("turbidity_sigma", told.sigma_turbidity, "Its standard deviation.");
  text.gauge("aod_550nm", told.aod_550, "Aerosol optical depth at 550 nm.");
  text.gauge("aod_550nm_sigma", told.sigma_aod_550, "Its standard deviation.");
  text.gauge("angstrom_exponent", told.angstrom_exponent, "Angstrom exponent of the aerosol.");
  text.gauge("air_age_seconds", told.air_age_s, "Since somebody saw the air.");
  text.gauge("air_supposed", as_number(told.air_supposed), "Whether the air is supposed, since nobody sees it.");
  text.gauge("visibility_meters", told.visibility_m, "Visibility by landmarks.");
  text.gauge("latency_median_seconds", in_seconds(told.latency_median_ms),
             "Capture to screen in the last minute, median.");
  text.gauge("latency_p95_seconds", in_seconds(told.latency_95_ms), "The same, which 95 % stay below.");
  text.counter("pictures_total", told.pictures, "Pictures shown since the start.");
  text.counter("frames_dropped_total", told.frames_dropped, "Pictures superseded before they were shown.");
  text.gauge("temperature_celsius", told.celsius, "Of the sensor nearest to its limits.");
  text.gauge("pictures_shown_ratio", told.pictures_share, "Share of pictures that is shown; less than 1: too hot.");
  text.gauge("failed_boots", told.failed_boots, "Boots in a row that came to nothing.");
  if (told.since)
    text.gauge("start_time_seconds", to_seconds(told.since->time_since_epoch()),
               "When the appliance started, Unix time.");
  tell_drift(told, text);
}

void tell_tries(const std::optional<OwnFigures::Tries>& tries, std::string_view name, std::string_view help,
                MetricsText& text) {
  if (!tries) return;
  text.head(name, "counter", help);
  text.value({{"outcome", "done"}}, static_cast<double>(tries->done));
  text.value({{"outcome", "failed"}}, static_cast<double>(tries->failed));
}

void tell_pulls(const std::optional<OwnFigures::Pulls>& pulls, MetricsText& text) {
  if (!pulls) return;
  text.head("report_content_pulls_total", "counter",
            "How often a web server was asked for content, by what came of it.");
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
  text.gauge("up", heard.contact == Contact::heard ? 1.0 : 0.0, "Whether the appliance tells its state.");
  text.gauge("picture_well", is_well(diagnosis.sight) ? 1.0 : 0.0,
             "Whether visitors see the building's picture, or it is closed on purpose.");
  text.head("sight", "gauge", "What visitors see: 1 for what is so.");
  for (const Sight sight : kAllSights) text.value({{"sight", name_of(sight)}}, sight == diagnosis.sight ? 1.0 : 0.0);
  text.head("symptom", "gauge", "What is wrong: 1 for what is so.");
  for (const Ill ill : kAllIlls) {
    double is = 0.0;
    for (const auto& symptom : diagnosis.symptoms)
      if (symptom.ill == ill) is = 1.0;
    text.value({{"symptom", name_of(ill)}}, is);
  }
  if (heard.status) tell_status(*heard.status, text);
  if (disk) {
    text.gauge("state_disk_free_bytes", disk->free_bytes, "Room left where the appliance keeps its state.");
    text.gauge("state_disk_size_bytes", disk->all_bytes, "Size of that disk.");
  }
  text.head("report_answers_total", "counter", "Answers to requests by status code.");
  for (const auto& [code, count] : own.answered) text.value({{"code", code}}, static_cast<double>(count));
  text.head("report_refused_total", "counter", "Peers that were refused or cut off, by reason.");
  for (const auto& [why, count] : own.refused) text.value({{"why", why}}, static_cast<double>(count));
  text.gauge("report_mqtt_connected", as_number(own.mqtt_connected), "Whether the MQTT broker takes what we tell.");
  tell_tries(own.mails, "report_mails_total", "Mails, by what came of them.", text);
  tell_tries(own.signs_of_life, "report_signs_of_life_total", "Signs of life, by what came of them.", text);
  tell_pulls(own.pulls, text);
  text.gauge("report_resident_memory_bytes", own.resident_bytes, "Memory of the reporter itself.");
  return text.text();
}

}  // namespace kasumi::report
