// Minutes of a day, for tests.
#pragma once

#include "base/utc_text.hpp"
#include "history/history_line.hpp"

namespace kasumi {

inline std::chrono::sys_time<std::chrono::minutes> minute(std::string_view text) {
  return std::chrono::floor<std::chrono::minutes>(*parse_utc(text));
}

// Nothing unknown in it, all of it as exact as a line keeps it.
inline HistoryLine whole_line() {
  HistoryLine line;
  line.number = 4711;
  line.utc = minute("2026-06-21T14:10:00Z");
  line.shown = Shown::still;
  line.trouble = Trouble::scene_white_out;
  line.hidden_s = 42;
  line.turbidity = 2.41;
  line.sigma_turbidity = 0.05;
  line.aod_550 = 0.123;
  line.sigma_aod_550 = 0.011;
  line.air_age_min = 125.0;
  line.scene_age_s = 1.5;
  line.sky_age_s = 0.25;
  line.latency_95_ms = 81.0;
  line.celsius = 61.0;
  line.pictures_share = 0.5;
  line.building = line.clock_trusted = true;
  return line;
}

}  // namespace kasumi
