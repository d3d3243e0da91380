// The air of some minutes ago, kept on disk so that a restart does not begin at nothing.
#pragma once

#include <filesystem>

#include "base/clock.hpp"
#include "base/result.hpp"
#include "estimator/site_sky.hpp"

namespace kasumi {

struct TurbidityState {
  Turbidity turbidity;
  double sigma = 0.0;
  Utc utc{};                                        // of the last estimate that was taken in
  SiteSkyModel sky_model = SiteSkyModel::preetham;  // whose T it is: never automatic
};

// folder/turbidity.json, old or new but never half of one. Error: io.
Result<> save(const TurbidityState& state, const std::filesystem::path& folder);
// Errors: bad_input (no such file; not what save() writes, or numbers that cannot be).
Result<TurbidityState> load_turbidity_state(const std::filesystem::path& folder);

}  // namespace kasumi
