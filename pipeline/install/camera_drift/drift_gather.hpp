// Gathers pictures for the check from a recording or from live cameras.
#pragma once

#include <functional>

#include "pipeline/install/camera_drift/drift_frames.hpp"
#include "pipeline/machine/devices.hpp"
#include "pipeline/site/config/fixture_file.hpp"

namespace kasumi {

// At most 15 of each camera, spread evenly over the recording. Errors: those of for_each_picture().
Result<DriftFrames> gather_recorded(const Fixture& fixture);

// 15 of each camera over `length`. BLOCKS for that time, or until `stop` returns true: then returns what has come so
// far; a person at a terminal sees how far it is. `time_known`: whether the clock can be trusted for the sun's position.
Result<DriftFrames> gather_live(const RunConfig& config, Devices& devices, Clock& clock, Duration length,
                                bool time_known, const std::function<bool()>& stop);

}  // namespace kasumi
