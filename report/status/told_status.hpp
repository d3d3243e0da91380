// What status.json tells, as far as it can be believed: whoever writes it may be broken or hostile.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/clock.hpp"
#include "base/result.hpp"
#include "base/words/rung.hpp"

namespace kasumi::report {

// Larger or deeper files are refused unread; longer texts are cut.
constexpr std::size_t kMostStatusBytes = 128 * 1024;
constexpr int kDeepestStatus = 12;
constexpr std::size_t kMostTextBytes = 400;
constexpr std::size_t kMostListed = 16;  // of any list

struct ToldCamera {
  bool up = false;
  std::string cause;      // why it is not up
  std::string condition;  // "normal", "frozen", ...
  std::string format;
  std::optional<double> down_s, last_good_age_s, good_frames, sequence_gaps, width_px, height_px, frames_per_second;
  double bad_frames = 0.0, reopened = 0.0;  // of all kinds
};

struct ToldDrift {
  std::string camera;  // "sky"
  std::string what;    // "dome"
  std::string words;
};

// Numbers are finite and possible; what is missing, of another type or impossible is empty. Counts are of the time since
// the appliance's start.
struct ToldStatus {
  std::optional<Shown> shown;
  std::optional<Trouble> trouble;  // empty: a reason that is not known here
  std::string reason;

  bool display_up = false;
  std::string display_cause;
  std::optional<double> flip_timeouts, display_resets;
  ToldCamera scene_camera, sky_camera;

  std::optional<double> turbidity, sigma_turbidity, turbidity_age_s;
  std::optional<double> aod_550, sigma_aod_550, angstrom_exponent;
  std::optional<double> air_age_s;  // since somebody saw it
  std::optional<bool> air_supposed;
  std::string air_text, aerosol, sky, sky_reason;

  std::optional<double> visibility_m, sigma_visibility_m;
  std::string visibility_bound, visibility_words;
  bool observers_disagree = false;

  std::optional<bool> screen_allowed;     // pictures of the screen for the state page
  std::optional<double> screen_pictures;  // taken
  std::optional<bool> clock_trusted;
  bool building_drawn = false;
  std::string draw_refused;
  std::optional<double> latency_median_ms, latency_95_ms;  // of the last minute
  std::optional<double> pictures, frames_dropped;

  std::string reloaded_utc, last_good_utc;
  std::vector<std::string> refused, reload_problems;  // of the content
  std::string arrived_words;                          // what came of the bundle that was brought last
  std::optional<Utc> arrived;
  bool safe_mode = false;
  std::optional<double> failed_boots;
  std::vector<std::string> start_why;

  std::string check_utc, check_summary;
  std::vector<ToldDrift> drifted;  // what the daily check found to have changed

  std::vector<std::string> hung_loops;
  std::optional<double> pictures_share, celsius;
  bool throttled = false;

  std::optional<Utc> utc, since;
  std::string boot;  // of the machine
  std::optional<double> since_boot_s, pid;
};

// Errors (bad_input): no JSON object, too large or too deep. Of everything else as much is kept as can be understood.
Result<ToldStatus> parse_status(std::string_view text);

}  // namespace kasumi::report
