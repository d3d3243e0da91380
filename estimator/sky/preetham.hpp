// The clear sky by turbidity: Perez 1993 distribution with Preetham 1999 coefficients (M Eq 6, physics 1).
#pragma once

#include <glm/vec3.hpp>

#include "base/geometry.hpp"
#include "base/units.hpp"
#include "estimator/atmosphere.hpp"

namespace kasumi {

// Perez' five numbers for one quantity and one turbidity, and their slopes in T.
struct PerezCoefficients {
  double a = 0.0, b = 0.0, c = 0.0, d = 0.0, e = 0.0;
};
enum class PerezQuantity { luminance, x, y };
PerezCoefficients perez_coefficients(PerezQuantity quantity, Turbidity turbidity);
PerezCoefficients perez_slopes(PerezQuantity quantity);  // d/dT: the coefficients are linear in T

// The horizon's 1 / cos theta is bounded by this; directions at and below the horizon take the horizon's value.
constexpr double kSmallestCosine = 0.001;
double clamp_cosine(double cosine);

// F(theta, gamma) = (1 + A exp(B / cos theta)) (1 + C exp(D gamma) + E cos^2 gamma).
double perez(const PerezCoefficients& k, double cos_theta, Radians gamma);

// Below this T the distribution has poles and negative values; every model is built with at least this.
Turbidity clamp_turbidity(Turbidity turbidity);

// Sky light for one T and one sun. Cheap to build; the sun must stand above the horizon for absolute luminance.
class PreethamSky {
 public:
  PreethamSky(Turbidity turbidity, const SunDirection& sun);

  // Y / Y(zenith)
  double luminance_ratio(const Direction& view) const;
  double luminance_ratio(double cos_theta, Radians gamma) const;
  // [kcd/m2]; 0 where the model goes negative (sun near the horizon, high T)
  double zenith_luminance() const { return zenith_.x; }
  // (Y [kcd/m2], x, y)
  glm::dvec3 luminance_and_chromaticity(const Direction& view) const;
  // CIE XYZ, Y in kcd/m2
  glm::dvec3 xyz(const Direction& view) const;
  // The same in units of the zenith's luminance: for ratios, which stay valid where the absolute scale does not.
  glm::dvec3 relative_xyz(const Direction& view) const;

  Turbidity turbidity() const { return turbidity_; }
  const SunDirection& sun() const { return sun_; }

 private:
  Turbidity turbidity_;
  SunDirection sun_;
  PerezCoefficients luminance_, x_, y_;
  glm::dvec3 zenith_{};     // Y, x, y
  glm::dvec3 at_zenith_{};  // F(0, theta_s) of the three
};

// XYZ of (Y, x, y); y must be > 0.
glm::dvec3 xyz_of(const glm::dvec3& luminance_and_chromaticity);

}  // namespace kasumi
