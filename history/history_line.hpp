// One minute of a kiosk's life, as a line of text.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/clock.hpp"
#include "base/status/rung.hpp"

namespace kasumi {

// What is not known is empty.
struct HistoryLine {
  std::uint32_t number = 0;  // of the line, from 1 on: they count minutes that were written, whatever the clock said
  std::chrono::sys_time<std::chrono::minutes> utc{};
  Shown shown = Shown::live;        // the worst of the minute
  Trouble trouble = Trouble::none;  // with it
  int hidden_s = 0;                 // so long visitors did not see the live picture, 0..60
  std::optional<double> turbidity, sigma_turbidity;
  std::optional<double> aod_550, sigma_aod_550;
  std::optional<double> air_age_min;             // since the air was last observed
  std::optional<double> scene_age_s, sky_age_s;  // since the cameras' last good picture
  std::optional<double> latency_95_ms;
  std::optional<double> celsius;
  std::optional<double> pictures_share;  // 0..1
  bool building = false, clock_trusted = false, air_supposed = false;
  friend bool operator==(const HistoryLine&, const HistoryLine&) = default;
};

// A number of the line: its column in tables, the figure of status.json that it keeps, and how.
struct HistoryColumn {
  std::string_view name;
  std::string_view figure;  // its key there
  std::optional<double> HistoryLine::*value;
  std::size_t digits = 4;  // in the file, at most
  double unit = 1.0;       // in the figure's own
};
struct HistoryFlag {
  std::string_view name, figure;
  bool HistoryLine::*value;
};

// In the order in which the file has them: more may follow at the end alone.
inline constexpr HistoryColumn kHistoryColumns[] = {
    {"turbidity", "turbidity", &HistoryLine::turbidity},
    {"sigma_turbidity", "sigma", &HistoryLine::sigma_turbidity},
    {"aod_550", "aod_550", &HistoryLine::aod_550},
    {"sigma_aod_550", "air.sigma_aod_550", &HistoryLine::sigma_aod_550},
    {"air_age_min", "air.age_s", &HistoryLine::air_age_min, 4, 60.0},
    {"scene_age_s", "scene_camera.last_good_age_s", &HistoryLine::scene_age_s, 3},
    {"sky_age_s", "sky_camera.last_good_age_s", &HistoryLine::sky_age_s, 3},
    {"latency_95_ms", "latency_ms_last_minute.p95", &HistoryLine::latency_95_ms, 3},
    {"celsius", "heat.celsius", &HistoryLine::celsius, 3},
    {"pictures_share", "heat.pictures_share", &HistoryLine::pictures_share, 3},
};
inline constexpr HistoryFlag kHistoryFlags[] = {
    {"building", "building_drawn", &HistoryLine::building},
    {"clock_trusted", "clock_trusted", &HistoryLine::clock_trusted},
    {"air_supposed", "air.supposed", &HistoryLine::air_supposed},
};

// With its line end. Numbers have 3 or 4 digits, blanks fill it up, and a checksum marks a line that a power cut tore.
constexpr std::size_t kHistoryLineBytes = 104;
std::string history_text(const HistoryLine& line);
// Empty: torn, blank or foreign.
std::optional<HistoryLine> parse_history(std::string_view text);

}  // namespace kasumi
