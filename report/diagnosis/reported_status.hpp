// What status.json tells, as far as it can be believed: whoever writes it may be broken or hostile.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/clock.hpp"
#include "base/result.hpp"
#include "base/status/rung.hpp"
#include "report/diagnosis/believed_figures.hpp"

namespace kasumi::report {

// Larger or deeper files are refused unread; longer texts are cut.
constexpr std::size_t kMostStatusBytes = 128 * 1024;
constexpr int kDeepestStatus = 12;
constexpr std::size_t kMostTextBytes = 400;
constexpr std::size_t kMostListed = 16;  // of any list

struct ReportedCamera {
  BelievedFigures<kCameraFigures> values;
  std::string cause;      // why it is not up
  std::string condition;  // "normal", "frozen", ...
  std::string format;
};

struct ToldDrift {
  std::string camera;  // "sky"
  std::string what;    // "dome"
  std::string words;
};

// Texts that are missing or of another type are empty. Counts are of the time since the appliance's start.
struct ReportedStatus {
  BelievedFigures<kStatusFigures> values;

  std::optional<Shown> shown;
  std::optional<Trouble> trouble;  // empty: a reason that is not known here
  std::string reason;

  std::string display_cause;
  ReportedCamera scene_camera, sky_camera;
  std::string air_text, aerosol, sky, sky_reason;
  std::string visibility_words;
  std::string draw_refused;

  std::string reloaded_utc, last_good_utc;
  std::vector<std::string> refused, reload_problems;           // of the content, the first few
  std::size_t refused_in_all = 0, reload_problems_in_all = 0;  // with those that are only counted
  std::string arrived_words;                                   // what came of the bundle that was brought last
  std::optional<Utc> arrived;
  std::vector<std::string> start_why;

  std::string check_utc;
  std::vector<ToldDrift> drifted;  // what the daily check found to have changed

  std::vector<std::string> hung_loops;

  std::optional<Utc> utc, since;
  std::string boot;  // of the machine
};

// Errors (bad_input): no JSON object, too large or too deep. Of everything else as much is kept as can be understood.
Result<ReportedStatus> parse_status(std::string_view text);

}  // namespace kasumi::report
