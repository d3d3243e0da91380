// The appliance's status: for operators, `kasumi doctor` and tests.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "history/history_line.hpp"
#include "pipeline/kiosk/appliance/status_mailbox.hpp"
#include "pipeline/kiosk/start/start_record.hpp"

namespace kasumi {

// A loop's sign of life.
struct LoopStatus {
  std::string name;                // "scene"
  std::optional<Duration> silent;  // since its last turn; empty: it has not begun
  bool hung = false;               // for longer than it may be
};

// The machine's heat, and what is spared for it.
struct HeatStatus {
  std::optional<ThermalZone> zone;  // nearest to its limits; empty: no sensor
  bool throttled = false;           // slowed down by the firmware now
  int show_one_of = 1;              // pictures
  std::uint64_t spared = 0;         // pictures since the start
};

// The state at `now`, from the latest reports of all loops, which may be older: a loop that hangs reports nothing.
struct Status {
  Instant now{};
  Utc utc{};
  Utc since{};
  CameraStatus scene_camera, sky_camera;
  SkyStatus sky;
  RenderStatus render;
  std::optional<StartRecord> start;            // empty: not started by the service
  std::optional<InsteadOfConfigured> instead;  // empty: the configured content is shown
  std::string era;                             // shown; empty: there are none
  ProbationStatus probation;
  std::optional<ReloadStatus> reload;  // empty: never reloaded
  std::optional<CheckStatus> check;    // empty: not checked since the start
  VisibilityStatus visibility;
  std::vector<LoopStatus> loops;
  HeatStatus heat;
  TelevisionStatus television;
};

// "every second picture is shown: cpu-thermal at 83 degrees, the firmware throttles"
std::string heat_text(const HeatStatus& heat);
// JSON; docs/operating.md lists its keys.
std::string status_json(const Status& status);
// "live, T 2.41 +- 0.05, 25.0 pictures a second"
std::string status_line(const Status& status);
// What `kasumi history` is to know of this second.
HistoryLine history_line(const Status& status);
// Several lines for a person: latency, copies, drops.
std::string stats_text(const Status& status);

}  // namespace kasumi
