// What has changed in two cameras since their calibration: turned, out of focus, fogged, dirty, brighter or darker.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pipeline/install/camera_drift/drift_reference.hpp"

namespace kasumi {

enum class DriftState { steady, drifted, undetermined };  // undetermined: these pictures cannot show it
std::string_view name_of(DriftState state);

struct DriftFinding {
  std::string camera;  // "sky", "scene"
  std::string what;    // "view", "sun", "focus", "lens", "dome", "exposure"
  DriftState state = DriftState::undetermined;
  std::string message;          // for a person
  std::optional<double> value;  // in `unit`
  std::optional<double> sigma;  // one standard deviation
  std::optional<double> alarm;  // values above this are called drift
  std::string unit;             // "deg", "percent"
};

struct DriftReport {
  Utc checked{};
  Utc reference{};  // when the reference was taken
  std::vector<DriftFinding> findings;
  bool steady() const;  // nothing drifted
};

// docs/calibration.md explains each finding and its threshold. Takes seconds with large pictures.
DriftReport find_drift(const DriftFrames& frames, const DriftReference& reference, const Installation& installation,
                       Utc now);

std::string drift_text(const DriftReport& report);     // a line for each finding
std::string drift_summary(const DriftReport& report);  // one line: what has drifted, or that nothing has

}  // namespace kasumi
