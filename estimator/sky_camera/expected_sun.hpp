// Where time and place put the sun, as evidence for what is seen in a picture.
#pragma once

#include "base/units.hpp"
#include "estimator/atmosphere.hpp"

namespace kasumi {

struct ExpectedSun {
  SunDirection direction{0.0, 0.0, 1.0};
  Radians sigma = from_degrees(2.0);
  bool azimuth_known = true;  // false: the camera's azimuth is unknown, only the zenith angle is expected
};

// The probability that what is seen `at` a place is the sun, which was `confidence` before it was asked where the sun is
// expected. What is not the sun is as likely everywhere; and the expectation itself may be wrong, by a clock or a place.
double confidence_where_expected(double confidence, const SunDirection& at, Radians sigma, const ExpectedSun& expected);

}  // namespace kasumi
