// What an appliance has learnt, kept on disk so that a restart does not begin at nothing. Each file is old or new, but
// never half of one.
#pragma once

#include <filesystem>

#include "base/clock.hpp"
#include "base/result.hpp"
#include "estimator/landmarks/landmark_air.hpp"
#include "estimator/sky/site_sky.hpp"

namespace kasumi {

// The air of some minutes ago.
struct TurbidityState {
  Turbidity turbidity;
  double sigma = 0.0;
  Utc utc{};                                        // of the last estimate that was taken in
  SiteSkyModel sky_model = SiteSkyModel::preetham;  // whose T it is: never automatic
};

// folder/turbidity.json. Error: io.
Result<> save(const TurbidityState& state, const std::filesystem::path& folder);
// Errors: bad_input (no such file; not what save() writes, or numbers that cannot be).
Result<TurbidityState> load_turbidity_state(const std::filesystem::path& folder);

// What the landmarks' contrasts have turned out to be, into folder/landmarks.json. Error: io.
Result<> save(const LandmarkWatch& watch, const std::filesystem::path& folder);
// false: nothing was saved there. Error (bad_input): of landmarks at other places or distances; not what save() writes.
// The watch then stays as it was.
Result<bool> resume(LandmarkWatch& watch, const std::filesystem::path& folder);

}  // namespace kasumi
