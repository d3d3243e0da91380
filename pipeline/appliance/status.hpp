// The appliance's status: for operators, `kasumi doctor` and tests.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pipeline/appliance/status_mailbox.hpp"

namespace kasumi {

struct Status {
  Instant now{};
  Utc utc{};
  Utc since{};
  CameraStatus scene_camera, sky_camera;
  SkyStatus sky;
  RenderStatus render;
  std::optional<ReloadStatus> reload;  // empty: never reloaded
  std::optional<CheckStatus> check;    // empty: not checked since the start
  VisibilityStatus visibility;
};

// JSON; docs/operating.md lists its keys.
std::string status_json(const Status& status);
// "live, T 2.41 +- 0.05, 25.0 pictures a second"
std::string status_line(const Status& status);
// Several lines for a person: latency, copies, drops.
std::string stats_text(const Status& status);

}  // namespace kasumi
