// Angles whose unit cannot be mistaken. Lengths are plain doubles in metres whose names end in _m; wavelengths end in
// _nm or _m.
#pragma once

#include <compare>
#include <numbers>

namespace kasumi {

struct Radians {
  double value = 0.0;
  friend constexpr auto operator<=>(Radians, Radians) = default;
  friend constexpr Radians operator+(Radians a, Radians b) { return {a.value + b.value}; }
  friend constexpr Radians operator-(Radians a, Radians b) { return {a.value - b.value}; }
  friend constexpr Radians operator-(Radians a) { return {-a.value}; }
  friend constexpr Radians operator*(double k, Radians a) { return {k * a.value}; }
  friend constexpr Radians operator*(Radians a, double k) { return {k * a.value}; }
};

constexpr double kPi = std::numbers::pi;

constexpr Radians from_degrees(double degrees) {
  return {degrees * kPi / 180.0};
}
constexpr double to_degrees(Radians angle) {
  return angle.value * 180.0 / kPi;
}

}  // namespace kasumi
