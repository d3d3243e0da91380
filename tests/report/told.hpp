// A status as an appliance in good health writes it, and changes to it.
#pragma once

#include <string>

#include <gtest/gtest.h>

#include "report/diagnosis/status_watch.hpp"

namespace kasumi::report {

inline const std::string kGoodStatus = R"({
  "shown": "live", "reason": "",
  "display": {"up": true, "description": "HDMI-A-1", "cause": "", "flips": 9000, "flip_timeouts": 1, "resets": 0},
  "scene_camera": {"up": true, "cause": "", "down_s": null, "last_good_age_s": 0.04, "condition": "normal",
    "good_frames": 9001, "bad_frames": {"short": 2, "corrupt": 1}, "opened": 1, "reopened": {"stall": 4}, "sequence_gaps": 5,
    "format": "MJPG", "width": 1920, "height": 1080, "mode": {"frames_per_second": 25.0}},
  "sky_camera": {"up": true, "cause": "", "last_good_age_s": 0.5, "condition": "normal", "good_frames": 4000,
    "bad_frames": {}, "reopened": {}, "sequence_gaps": 0, "format": "YUYV", "width": 480, "height": 480},
  "turbidity": 2.41, "sigma": 0.05, "turbidity_age_s": 12.5, "turbidity_trustworthy": true,
  "aod_550": 0.12, "angstrom_exponent": 1.3, "aerosol": "continental",
  "air": {"text": "clear", "supposed": false, "age_s": 12.5, "sigma_aod_550": 0.01},
  "sky": "clear", "sky_reason": "", "building_drawn": true, "draw_refused": null, "clock_trusted": true,
  "latency_ms_last_minute": {"median": 62.1, "p95": 80.4, "max": 120.0, "pictures": 1500},
  "frames_dropped": 7, "pictures": 9000,
  "content": {"reloaded_utc": null, "problems": [], "reloading": null, "last_good_utc": null, "refused": []},
  "start": {"safe_mode": false, "trial": false, "failed_boots": 0, "why": []},
  "check": {"utc": "2026-06-21T11:30:00Z", "summary": "nothing has changed", "well": true, "findings":
    [{"camera": "sky", "what": "dome", "state": "steady", "words": "clean"}]},
  "visibility": {"visibility_m": 32000, "sigma_m": 3000, "bound": null, "finding": false, "words": "agrees"},
  "loops": {"scene": {"up": true, "silent_s": 0.1}, "check": {"up": false, "silent_s": null}},
  "heat": {"pictures_share": 1.0, "zone": "cpu", "celsius": 51.5, "throttled": false, "spared": 0},
  "pid": 4711, "since_utc": "2026-06-20T08:00:00Z", "utc": "2026-06-21T12:00:00Z"
})";

// The status with one piece of its text replaced, which must be there.
inline std::string changed(std::string text, const std::string& what, const std::string& by) {
  const auto at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return at == std::string::npos ? text : text.replace(at, what.size(), by);
}

// Its scene camera is unplugged: visitors see the still picture.
inline const std::string kLostStatus = changed(
    changed(kGoodStatus, "\"live\", \"reason\": \"\"", "\"still\", \"reason\": \"no picture from the scene camera\""),
    "\"scene_camera\": {\"up\": true, \"cause\": \"\"", "\"scene_camera\": {\"up\": false, \"cause\": \"unplugged\"");

inline Heard heard_of(const std::string& text) {
  auto status = parse_status(text);
  EXPECT_TRUE(status) << status.error().message;
  return {Contact::heard, status ? std::optional(*status) : std::nullopt, {}, {}};
}

inline const Heard kWellKiosk = heard_of(kGoodStatus), kLostKiosk = heard_of(kLostStatus);

}  // namespace kasumi::report
