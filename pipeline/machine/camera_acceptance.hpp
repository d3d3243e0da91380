// Which frames of a camera can be used: asked by the appliance of every frame, and by those who check content beforehand of
// one, so that they never call valid what can never go live.
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

// "1280x720 instead of 960x540 (120)": the reason that came most often; empty: there is none.
std::string commonest(const std::map<std::string, std::uint64_t>& reasons);

// Opens both cameras, where they are here and nobody else has them, and waits for a frame of each that can be used. BLOCKS
// for some seconds. Error (bad_input): what comes of one can never be used, or is a recording without its frames; all
// problems at once. `untried`: why a camera could not be asked.
Result<> try_cameras(const RunConfig& config, Devices& devices, Clock& clock, std::vector<std::string>& untried);

}  // namespace kasumi
