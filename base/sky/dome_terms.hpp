// The terms of the dome's sum (base/sky/dome_function.hpp) in double precision: used to fit its table and as the
// shader's reference.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/geometric.hpp>

#include "base/geometry.hpp"
#include "base/sky/dome_function.hpp"

namespace kasumi {

constexpr int kDomeTerms = kDomeAngles * kDomePowers;

// In the order of the coefficients. Reads only horizon_sine, steepness and lobes of the function. `height`: sine of the
// view's elevation; `g`: cosine of its angle to the sun.
inline std::array<double, kDomeTerms> dome_terms(const DomeFunction& sky, double height, double g) {
  const double h = sky.horizon_sine, m = std::max(0.0, (height - h) / (1.0 - h));
  const double u = 1.0 / (1.0 + double{sky.steepness} * m);
  const auto lobe = [g](double a) {
    const double q = (1.0 - a) * (1.0 - a) / (1.0 + a * a - 2.0 * a * g);
    return q * std::sqrt(q);
  };
  const std::array<double, kDomeAngles> angle{1.0, g, g * g, lobe(sky.lobes.x), lobe(sky.lobes.y), lobe(sky.lobes.z)};
  std::array<double, kDomeTerms> terms{};
  for (int j = 0; j < kDomeAngles; ++j) {
    double power = angle[j];
    for (int k = 0; k < kDomePowers; ++k, power *= u) terms[j * kDomePowers + k] = power;
  }
  return terms;
}
inline std::array<double, kDomeTerms> dome_terms(const DomeFunction& sky, const Direction& view) {
  return dome_terms(sky, view.z, glm::dot(view, glm::dvec3(sky.sun)));
}

}  // namespace kasumi
