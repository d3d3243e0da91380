// Samples of a sky of known light with Gaussian noise, without a picture in between.
#pragma once

#include <cmath>
#include <vector>

#include "estimator/turbidity/sky_samples.hpp"
#include "tests/estimator/turbidity/synthetic_sky.hpp"

namespace kasumi::test {

// Uniform in solid angle down to 80 deg from the zenith, 10 deg and more from the sun. `luminance`: by direction.
template <class Luminance>
std::vector<LuminanceSample> samples_of(const Luminance& luminance, const SunDirection& sun, std::size_t count,
                                        double noise, std::uint64_t seed = 1) {
  std::vector<LuminanceSample> samples;
  const double lowest = std::cos(from_degrees(80.0).value);
  for (std::uint64_t i = 0; samples.size() < count; ++i) {
    const double z = lowest + (1.0 - lowest) * hashed_uniform(2 * seed + 100, i);
    const Direction view = direction_from({std::acos(z)}, {2.0 * kPi * hashed_uniform(2 * seed + 101, i)});
    const double gamma = angle_between(view, sun).value;
    if (gamma < from_degrees(10.0).value) continue;
    const double log_y = std::log(luminance(view)) + noise * hashed_normal(seed + 7777, i);
    samples.push_back({static_cast<float>(std::acos(z)), static_cast<float>(gamma), static_cast<float>(log_y),
                       static_cast<float>(noise), 0.0f});
  }
  return samples;
}

}  // namespace kasumi::test
