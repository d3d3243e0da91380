// From a sky scanner's readings to the air above, or the reason why they do not determine it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "estimator/atmosphere.hpp"
#include "estimator/sky/site_sky.hpp"
#include "estimator/sky_fit/sky_fit.hpp"
#include "estimator/sky_fit/sky_reading.hpp"

namespace kasumi {

// Sky radiometers leave out what is nearer to the sun: the instrument's own glare, and the disc in its field of view.
constexpr Radians kNearestScanToSun = from_degrees(10.0);
// Land, trees and the thickest haze stand lower.
constexpr Radians kLowestScan = from_degrees(5.0);  // elevation

struct ScanEstimate {
  TurbidityEstimate estimate;      // its samples: directions
  ModelToFit sky;                  // the model to which T belongs
  std::vector<std::uint8_t> used;  // by reading: it agrees with that model
};

// `sun`: high enough for a fit. Single bad directions and clouds are recognised by their residuals under the likeliest
// model.
ScanEstimate estimate_from_scan(std::span<const SkyReading> readings, const SunDirection& sun, const ModelToFit& sky,
                                const InstrumentDoubt& scanner);

}  // namespace kasumi
