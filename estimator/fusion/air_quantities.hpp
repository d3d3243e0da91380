// The quantities of which the tracker's state consists.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "base/clock.hpp"
#include "base/square.hpp"

namespace kasumi {

// Amounts of aerosol are in ln(aod_550 + kSmallAerosol): .1 is a tenth more or less haze, and no haze is a number.
constexpr double kSmallAerosol = 0.01;

enum AirQuantity : std::size_t {
  kAmount,  // of the column
  kExponent,
  kNearGround,  // ln: amount of the path over the column's
  // Errors that last (LastingErrors).
  kSkyAmountError,
  kSkyExponentError,
  kHorizonAmountError,
  kHorizonExponentError,
  kPathError,  // of all channels alike
  kRedError,
  kGreenError,
  kBlueError,
  kAirQuantities
};

inline double log_amount(double aod) {
  return std::log(std::max(0.0, aod) + kSmallAerosol);
}
inline double aod_of(double log_amount) {
  return std::max(0.0, std::exp(log_amount) - kSmallAerosol);
}
// Of log_amount(aod). Bounded, though aod may be uncertain by more than itself.
inline double log_sigma(double aod, double sigma) {
  return sigma / std::hypot(std::max(0.0, aod) + kSmallAerosol, sigma);
}

inline Duration passed_between(Instant from, Instant to) {
  return std::max(Duration{0}, to - from);
}

}  // namespace kasumi
