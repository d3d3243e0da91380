// Visibility from landmarks against what an instrument measured beside them (`kasumi estimate --scene --measured`).
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "estimator/landmarks/channel_extinctions.hpp"

namespace kasumi {

// Meteorological optical range (5 %, as WMO's instruments give it) by the picture's file name, in metres.
using MeasuredVisibilities = std::map<std::string, double>;
// CSV with the columns name and visibility_m. Errors: bad_input (every line that is wrong).
Result<MeasuredVisibilities> read_measured_visibilities(const std::filesystem::path& file);

struct VisibilityCheck {
  ExtinctionKind kind = ExtinctionKind::nothing;  // of Kasumi's own estimate
  double measured_m = 0.0, ours_m = 0.0;          // optical range; `ours_m` is Kasumi's value, or its bound
  double factor = 0.0;                            // ours over measured
  double sigmas = 0.0;                            // of a value: Kasumi's less measured extinction over Kasumi's sigma
  bool holds = false;                             // a bound that the measured keeps; a value within 2 sigma
};
VisibilityCheck check_visibility(const ChannelExtinctions& air, double measured_m);
// For people, each with a line break.
std::string check_text(const VisibilityCheck& check);
std::string checks_text(const std::vector<VisibilityCheck>& checks);  // all of them together

}  // namespace kasumi
