// The figures of status.json: its keys, what is believed of them, and where kasumi-report shows them. The appliance writes
// them (tests/report/test_contract.cpp); all else is made from these tables.
#pragma once

#include <cstddef>
#include <string_view>

namespace kasumi {

enum class FigureKind {
  number,
  flag,   // true or false; else unknown
  is_so,  // true; anything else is no
  sum,    // of an object's counts; anything else is 0
};

struct Believed {
  double lowest = 0.0, highest = 0.0;
  FigureKind kind = FigureKind::number;
};
inline constexpr Believed kCounted{0.0, 9007199254740992.0};  // 2^53: counts beyond are not exact
inline constexpr Believed kSeconds{0.0, 1e9};                 // 30 years
inline constexpr Believed kFlag{0.0, 1.0, FigureKind::flag}, kIsSo{0.0, 1.0, FigureKind::is_so};
inline constexpr Believed kSummed{0.0, 9007199254740992.0, FigureKind::sum};

// On the page, and as an entity of Home Assistant.
struct FigureShown {
  double metric_unit = 1.0;  // of the metric, in the figure's own
  std::string_view text{};   // its name, an entry of the languages' files; empty: shown on neither
  std::string_view unit{};   // of the entity; "1": none
  std::string_view device_class{};
  double page_unit = 1.0;        // of the page, in the figure's own
  std::string_view page{};       // "{:.0f} km"
  std::string_view beside{};     // another figure's key, which the page shows with it
  std::string_view page_both{};  // "{:.0f} ± {:.0f} km"
  bool machine = false;          // of the machine rather than of the air: below the cameras
};

struct StatusFigure {
  std::string_view key;   // "air.age_s"
  std::string_view what;  // a sentence: the metric's help
  Believed believed;
  std::string_view metric{};  // of Prometheus, after "kasumi_"; a counter if it ends in "_total"; empty: none
  std::string_view mqtt{};    // key of the state; empty: not there
  FigureShown shown{};
  std::string_view otherwise{};  // the key that is read where this one has no value
};

inline constexpr StatusFigure kStatusFigures[] = {
    {"building_drawn", "Whether the building is in the picture.", kIsSo, "building_drawn"},
    {"display.up", "Whether there is a screen.", kIsSo, "display_up"},
    {"display.flip_timeouts", "Pictures that the screen did not take in time.", kCounted,
     "display_flip_timeouts_total"},
    {"display.resets", "How often the screen had to be opened again.", kCounted, "display_resets_total"},
    {"clock_trusted", "Whether the machine's time is trusted.", kFlag, "clock_trusted", "clock_trusted"},
    {"turbidity",
     "T of the air that drives the picture.",
     {0.0, 1000.0},
     "turbidity",
     "turbidity",
     {.text = "figure.turbidity", .unit = "1", .page = "{:.2f}", .beside = "sigma", .page_both = "{:.2f} ± {:.2f}"}},
    {"sigma", "Its standard deviation.", {0.0, 1000.0}, "turbidity_sigma", "sigma_turbidity"},
    {"aod_550",
     "Aerosol optical depth at 550 nm.",
     {0.0, 100.0},
     "aod_550nm",
     "aod_550",
     {.text = "figure.aod",
      .unit = "1",
      .page = "{:.3f}",
      .beside = "air.sigma_aod_550",
      .page_both = "{:.3f} ± {:.3f}"}},
    {"air.sigma_aod_550", "Its standard deviation.", {0.0, 100.0}, "aod_550nm_sigma", "sigma_aod_550"},
    {"angstrom_exponent", "Angstrom exponent of the aerosol.", {-10.0, 10.0}, "angstrom_exponent"},
    {"air.age_s", "Since somebody saw the air.", kSeconds, "air_age_seconds", "air_age_s", {}, "turbidity_age_s"},
    {"air.supposed", "Whether the air is supposed, since nobody sees it.", kFlag, "air_supposed"},
    {"visibility.visibility_m",
     "Visibility by landmarks.",
     {0.0, 1e7},
     "visibility_meters",
     "visibility_m",
     {.text = "figure.visibility",
      .unit = "m",
      .device_class = "distance",
      .page_unit = 1000.0,
      .page = "{:.0f} km",
      .beside = "visibility.sigma_m",
      .page_both = "{:.0f} ± {:.0f} km"}},
    {"visibility.sigma_m", "Its standard deviation.", {0.0, 1e7}},
    {"visibility.finding", "Whether sky and landmarks disagree.", kIsSo},
    {"latency_ms_last_minute.median",
     "Capture to screen in the last minute, median.",
     {0.0, 1e6},
     "latency_median_seconds",
     "latency_ms",
     {.metric_unit = 1000.0,
      .text = "figure.latency",
      .unit = "ms",
      .device_class = "duration",
      .page = "{:.0f} ms",
      .beside = "latency_ms_last_minute.p95",
      .page_both = "{:.0f} ms; 95 %: {:.0f} ms",
      .machine = true}},
    {"latency_ms_last_minute.p95",
     "The same, which 95 % stay below.",
     {0.0, 1e6},
     "latency_p95_seconds",
     "",
     {.metric_unit = 1000.0}},
    {"pictures", "Pictures shown since the start.", kCounted, "pictures_total"},
    {"frames_dropped", "Pictures superseded before they were shown.", kCounted, "frames_dropped_total"},
    {"heat.celsius",
     "Of the sensor nearest to its limits.",
     {-100.0, 300.0},
     "temperature_celsius",
     "temperature_celsius",
     {.text = "figure.temperature", .unit = "°C", .device_class = "temperature", .page = "{:.0f} °C", .machine = true}},
    {"heat.pictures_share",
     "Share of pictures that is shown; less than 1: too hot.",
     {0.0, 1.0},
     "pictures_shown_ratio"},
    {"heat.throttled", "Whether the firmware throttles.", kIsSo},
    {"start.failed_boots", "Boots in a row that came to nothing.", kCounted, "failed_boots"},
    {"start.safe_mode", "Whether too many starts have failed.", kIsSo},
    {"screen_picture.allowed", "Whether the state page may ask for pictures of the screen.", kFlag},
    {"screen_picture.taken", "Such pictures since the start.", kCounted},
    {"visitor.presses",
     "What visitors pressed, turned and wiped since the start.",
     kCounted,
     "visitor_presses_total",
     "visitor_presses",
     {.text = "figure.presses", .unit = "1", .page = "{:.0f}", .machine = true}},
    {"since_boot_s", "Since the machine's boot.", kSeconds},
    {"pid", "The appliance's process.", {1.0, 4194304.0}},
};

// Of each camera, below "scene_camera" and "sky_camera"; their metrics have the label `camera`.
inline constexpr StatusFigure kCameraFigures[] = {
    {"up", "Whether pictures come from the camera.", kIsSo, "camera_up"},
    {"last_good_age_s", "Since the camera's last good picture.", kSeconds, "camera_last_good_age_seconds"},
    {"good_frames", "Good pictures since the start.", kCounted, "camera_frames_total"},
    {"bad_frames", "Damaged pictures since the start.", kSummed, "camera_bad_frames_total"},
    {"reopened", "How often the camera had to be opened again.", kSummed, "camera_reopened_total"},
    {"sequence_gaps", "Pictures that the driver dropped.", kCounted, "camera_sequence_gaps_total"},
    {"down_s", "How long it has been away.", kSeconds},
    {"mode.frames_per_second", "That its mode promises.", {0.0, 10000.0}},
    {"width", "Of its pictures, pixels.", {1.0, 65536.0}},
    {"height", "Of its pictures, pixels.", {1.0, 65536.0}},
};

// The place of a key in one of the tables. A key that is not there does not compile.
template <const auto& kFigures>
struct FigureKey {
  consteval FigureKey(const char* key) {
    while (kFigures[index].key != key) ++index;
  }
  std::size_t index = 0;
};

}  // namespace kasumi
