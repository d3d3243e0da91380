#include "tests/estimator/sky_fit/skies_as_readings.hpp"

#include <cmath>
#include <memory>
#include <random>

#include <glm/exponential.hpp>

#include "base/units.hpp"
#include "calib/colour/colorimetry.hpp"
#include "fixtures/spectrum/spectrum.hpp"

namespace kasumi::test {

std::vector<Direction> spread_directions(const SunDirection& sun, int many, double nearest_deg) {
  std::vector<Direction> directions;
  const double golden = kPi * (3.0 - std::sqrt(5.0));
  for (int i = 0; i < many; ++i) {
    const double height = (i + 0.5) / many;
    const Direction direction = direction_from({std::acos(height)}, {std::fmod(golden * i, 2.0 * kPi)});
    if (height < std::sin(from_degrees(8.0).value)) continue;
    if (to_degrees(angle_between(direction, sun)) < nearest_deg) continue;
    directions.push_back(direction);
  }
  return directions;
}

std::vector<SkyReading> readings_of(const std::vector<Direction>& directions,
                                    const std::function<glm::dvec3(const Direction&)>& linear_srgb,
                                    const ReadingFaults& faults) {
  std::mt19937_64 random(faults.seed);
  std::normal_distribution<double> normal;
  std::vector<SkyReading> readings;
  for (const Direction& direction : directions) {
    SkyReading reading;
    reading.direction = direction;
    reading.off_axis = zenith_angle(direction).value / (0.5 * kPi);
    const double falloff = faults.vignetting * reading.off_axis * reading.off_axis;
    glm::dvec3 change{faults.log_red + falloff, falloff, faults.log_blue + falloff};
    for (int c = 0; c < 3; ++c) change[c] += faults.noise * normal(random);
    reading.light = linear_srgb(direction) * glm::exp(change);
    reading.sigma = glm::dvec3(faults.noise);
    readings.push_back(reading);
  }
  return readings;
}

std::function<glm::dvec3(const Direction&)> spectral_sky(const reference::Air& air, double altitude_m,
                                                         const SunDirection& sun) {
  const auto sky =
      std::make_shared<reference::ReferenceSky>(air, 20.0, reference::suns_around_deg(to_degrees(zenith_angle(sun))));
  return [sky, altitude_m, sun](const Direction& view) {
    return xyz_to_linear_srgb() * sky->xyz({altitude_m, view, sun});
  };
}

std::vector<SkyReading> readings_of(const reference::MeasuredSky& sky) {
  const auto& cie = fixtures::cie_1931();
  std::vector<SkyReading> readings;
  for (std::size_t d = 0; d < sky.directions.size(); ++d) {
    const fixtures::Spectrum spectrum =
        fixtures::resample(sky.light[d], sky.wavelengths_nm.front(), sky.wavelengths_nm[1] - sky.wavelengths_nm[0]);
    glm::dvec3 xyz{0.0};
    for (std::size_t i = 0; i < spectrum.size(); ++i)
      xyz += fixtures::kLumensPerWatt * spectrum[i] * glm::dvec3(cie.x[i], cie.y[i], cie.z[i]);
    readings.push_back({sky.directions[d], xyz_to_linear_srgb() * xyz, glm::dvec3(0.01), 0.0});
  }
  return readings;
}

}  // namespace kasumi::test
