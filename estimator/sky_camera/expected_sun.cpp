#include "estimator/sky_camera/expected_sun.hpp"

#include <algorithm>
#include <cmath>

#include "base/square.hpp"

namespace kasumi {

double confidence_where_expected(double confidence, const SunDirection& at, Radians sigma,
                                 const ExpectedSun& expected) {
  constexpr double kWrong = 0.05;  // one clock, place or mounting in twenty is taken to be wrong
  const double variance = square(sigma.value) + square(expected.sigma.value);
  const auto bell = [&](Radians off) { return std::exp(-0.5 * square(off.value) / variance); };
  // Densities over those of a place anywhere in the sky; its zenith angle has the density sin(zenith angle).
  const Radians zenith = zenith_angle(expected.direction);
  const double density =
      expected.azimuth_known
          ? bell(angle_between(at, expected.direction)) / variance
          : bell(zenith_angle(at) - zenith) / (std::sqrt(2.0 * kPi * variance) * std::max(std::sin(zenith.value), 0.1));
  const double likelier = kWrong + (1.0 - kWrong) * density;
  return confidence * likelier / (confidence * likelier + 1.0 - confidence);
}

}  // namespace kasumi
