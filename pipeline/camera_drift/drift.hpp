// What has changed of two cameras since they were calibrated: turned, out of focus, fogged, dirty, brighter or darker.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pipeline/camera_drift/drift_reference.hpp"

namespace kasumi {

enum class DriftState { steady, drifted, undetermined };  // untold: nothing of it can be seen in these pictures
std::string_view name_of(DriftState state);

struct DriftFinding {
  std::string camera;  // "sky", "scene"
  std::string what;    // "view", "sun", "focus", "lens", "dome", "exposure"
  DriftState state = DriftState::undetermined;
  std::string message;          // for a person
  std::optional<double> value;  // in `unit`
  std::optional<double> sigma;  // one standard deviation
  std::optional<double> alarm;  // the value from which on it is called drift
  std::string unit;             // "deg", "percent"
};

struct DriftReport {
  Utc checked{};
  Utc reference{};  // when that was taken
  std::vector<DriftFinding> findings;
  bool steady() const;  // nothing drifted
};

// docs/calibration.md tells what each finding means and where its bound is from. Takes seconds with large pictures.
DriftReport find_drift(const DriftFrames& frames, const DriftReference& reference, const Installation& installation,
                       Utc now);

std::string drift_text(const DriftReport& report);     // a line for each finding
std::string drift_summary(const DriftReport& report);  // "well", or what has drifted, in one line

}  // namespace kasumi
