// Skies as readings: the spectral atmosphere's, measured ones, Preetham's and the dome's own.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "estimator/sky_fit/sky_fit.hpp"
#include "fixtures/atmosphere/reference_sky.hpp"
#include "tests/fixtures/atmosphere/cornell_skies.hpp"

namespace kasumi::test {

// Some `many` directions spread evenly over the sky, none lower than 8 deg or nearer to the sun than `nearest_deg`.
std::vector<Direction> spread_directions(const SunDirection& sun, int many = 300, double nearest_deg = 5.0);

// What an instrument adds.
struct ReadingFaults {
  double noise = 0.002;  // relative
  double log_red = 0.0, log_blue = 0.0;
  double vignetting = 0.0;  // of ln light at the lens' edge
  std::uint64_t seed = 1;
};
// Looking straight up: off_axis is the zenith angle over 90 deg.
std::vector<SkyReading> readings_of(const std::vector<Direction>& directions,
                                    const std::function<glm::dvec3(const Direction&)>& linear_srgb,
                                    const ReadingFaults& faults = {});

// Linear sRGB of the spectral atmosphere.
std::function<glm::dvec3(const Direction&)> spectral_sky(const reference::Air& air, double altitude_m,
                                                         const SunDirection& sun);

// Of the scanner's spectra.
std::vector<SkyReading> readings_of(const reference::MeasuredSky& sky);

}  // namespace kasumi::test
