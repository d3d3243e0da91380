// The drift check's report for programs: docs/calibration.md lists its keys.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "pipeline/install/camera_drift/drift.hpp"

namespace kasumi {

std::string drift_json(const DriftReport& report);  // one object
// Only its list of findings.
nlohmann::ordered_json findings_json(const DriftReport& report);

}  // namespace kasumi
