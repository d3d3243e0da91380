// Which frames of a camera can be used: checked by the appliance for every frame, and by checks of content for one, so
// that these never pass content that cannot go live.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "capture/frame.hpp"
#include "pipeline/machine/devices.hpp"
#include "pipeline/site/config/run_config.hpp"

namespace kasumi {

// Empty: it can be; else "1280x720 instead of 960x540".
std::string why_unusable(const FrameMetadata& frame, const Camera& camera);
// The same of a whole frame, which is decoded: "truncated", "JPEG size 640x360: expected 1280x720".
std::string why_unusable(const Frame& frame, const Camera& camera);

// "1280x720 instead of 960x540 (120)": the reason that came most often; empty: there is none.
std::string commonest(const std::map<std::string, std::uint64_t>& reasons);

// Opens both cameras, if they are present and not in use, and waits for a usable frame of each. BLOCKS for some
// seconds. Error (bad_input): a camera's frames can never be used, or it is a recording without its frames; all
// problems at once. `untried`: why a camera could not be tried.
Result<> try_cameras(const RunConfig& config, Devices& devices, Clock& clock, std::vector<std::string>& untried);

}  // namespace kasumi
