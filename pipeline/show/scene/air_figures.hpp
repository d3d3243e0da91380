// The uncertainty of the air's state, in the numbers of status, tables and plots.
#pragma once

#include <optional>
#include <string>

#include "pipeline/show/scene/sky_watch.hpp"

namespace kasumi {

// Standard deviations of the aerosol's optical depth and exponent; of the papers' air what that of T means.
double aod_sigma(const TrackedAir& state);
double angstrom_sigma(const TrackedAir& state);
// Of the air that was seen or given; empty: it was not.
std::optional<AirQuality> seen_quality(const SkyReport& report, double altitude_m);
// "sky .72, landmarks .28": each observer's share of what is known; "supposed" where nobody has seen the air.
std::string observers_text(const TrackedAir& state);
// The observers that are farthest from the others: over both sigmas; 0: they agree, or there is only one.
double largest_disagreement_sigmas(const TrackedAir& state);

}  // namespace kasumi
