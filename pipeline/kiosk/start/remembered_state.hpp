// What an appliance has learnt, kept on disk so that a restart does not begin from nothing. Files are replaced
// atomically, and only when there is something new: flash memory wears.
#pragma once

#include <filesystem>
#include <string>

#include "base/clock.hpp"
#include "base/result.hpp"
#include "estimator/fusion/air_tracker.hpp"
#include "estimator/landmarks/channel_extinctions.hpp"
#include "estimator/sky/site_sky.hpp"

namespace kasumi {

// The last estimate of the air.
struct TurbidityState {
  Turbidity turbidity;
  double sigma = 0.0;
  Utc utc{};                                          // of the last estimate used
  DaylightModel sky_model = DaylightModel::preetham;  // the model T belongs to; never automatic
  // Kind and exponent of the dome that was fitted, where they were given: T of another aerosol is another amount.
  std::string aerosol{};  // empty: not given
  double angstrom_exponent = 0.0;
  std::optional<RememberedAir> air{};  // the whole state; empty: T alone was followed, or the file is an old one

  // Whether the state, or T without it, is what finding the air by this sky gives.
  bool belongs_to(const ModelToFit& sky) const;
};

// Of a T estimated by fitting `sky`.
TurbidityState turbidity_state(Turbidity turbidity, double sigma, Utc utc, const ModelToFit& sky);

// folder/turbidity.json, unless it holds the state after the same reading. Error: io.
Result<> save(const TurbidityState& state, const std::filesystem::path& folder);
// Errors: bad_input (no such file, not written by save(), impossible numbers), io.
Result<TurbidityState> load_turbidity_state(const std::filesystem::path& folder);

// The readings of landmarks that are kept, into folder/landmarks.json. Error: io.
Result<> save(const LandmarkWatch& watch, const std::filesystem::path& folder);
// false: nothing was saved there. Errors: bad_input (saved for landmarks at other places or distances or by another
// response of the camera, or not written by save()), io; the watch then stays unchanged.
Result<bool> resume(LandmarkWatch& watch, const std::filesystem::path& folder);

}  // namespace kasumi
