// Pictures for the check, out of a recording or of the live cameras.
#pragma once

#include <functional>

#include "pipeline/camera_drift/drift_frames.hpp"
#include "pipeline/config/fixture_file.hpp"
#include "pipeline/machine/devices.hpp"

namespace kasumi {

// At most 15 of each camera, evenly over the recording. Errors: what the recording's reader finds.
Result<DriftFrames> gather_recorded(const Fixture& fixture);

// 15 of each over `length`. BLOCKS so long, or until `stop` says so; what came by then is given. `time_known`: whether
// the clock's time tells where the sun stands.
Result<DriftFrames> gather_live(const RunConfig& config, Devices& devices, Clock& clock, Duration length,
                                bool time_known, const std::function<bool()>& stop);

}  // namespace kasumi
