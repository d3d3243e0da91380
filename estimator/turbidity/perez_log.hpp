// ln F and its slope in T at a point of the sky: the model term of every residual here.
#pragma once

#include <cmath>

#include "estimator/sky/preetham.hpp"
#include "estimator/turbidity/sky_samples.hpp"

namespace kasumi {

// A sample's position in the variables of the distribution.
struct PerezPoint {
  double per_cosine = 1.0;  // 1 / cos of the zenith angle
  double gamma = 0.0;       // distance from the sun [rad]
  double cos2_gamma = 1.0;
};
inline PerezPoint perez_point(const LuminanceSample& sample) {
  const auto gamma = static_cast<double>(sample.sun_distance);
  const double cosine = std::cos(gamma);
  return {1.0 / clamp_cosine(std::cos(static_cast<double>(sample.zenith))), gamma, cosine * cosine};
}

class PerezLog {
 public:
  explicit PerezLog(Turbidity turbidity)
      : k_(perez_coefficients(PerezQuantity::luminance, turbidity)), d_(perez_slopes(PerezQuantity::luminance)) {}

  struct Value {
    double log_f = 0.0;
    double slope = 0.0;  // d ln F / dT
  };
  Value at(const PerezPoint& p) const {
    const double gradation = std::exp(k_.b * p.per_cosine), indicatrix = std::exp(k_.d * p.gamma);
    const double f1 = 1.0 + k_.a * gradation;
    const double f2 = 1.0 + k_.c * indicatrix + k_.e * p.cos2_gamma;
    const double slope1 = (d_.a + k_.a * d_.b * p.per_cosine) * gradation;
    const double slope2 = (d_.c + k_.c * d_.d * p.gamma) * indicatrix + d_.e * p.cos2_gamma;
    return {std::log(f1 * f2), slope1 / f1 + slope2 / f2};
  }

 private:
  PerezCoefficients k_, d_;
};

}  // namespace kasumi
