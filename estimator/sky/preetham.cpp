#include "estimator/sky/preetham.hpp"

#include <algorithm>
#include <cmath>

namespace kasumi {

namespace {

// slope * T + offset (Preetham 1999, appendix A.2; physics 1)
struct Table {
  PerezCoefficients slope, offset;
};
// Preetham 1999, appendix A.2.
constexpr Table kLuminance{{.1787, -.3554, -.0227, .1206, -.0670}, {-1.4630, .4275, 5.3251, -2.5771, .3703}};
constexpr Table kX{{-.0193, -.0665, -.0004, -.0641, -.0033}, {-.2592, .0008, .2125, -.8989, .0452}};
constexpr Table kY{{-.0167, -.0950, -.0079, -.0441, -.0109}, {-.2608, .0092, .2102, -1.6537, .0529}};

const Table& table_of(PerezQuantity quantity) {
  switch (quantity) {
    case PerezQuantity::x: return kX;
    case PerezQuantity::y: return kY;
    case PerezQuantity::luminance: break;
  }
  return kLuminance;
}

double zenith_luminance_kcd(double t, double sun_zenith) {
  const double chi = (4.0 / 9.0 - t / 120.0) * (kPi - 2.0 * sun_zenith);
  return std::max(0.0, (4.0453 * t - 4.9710) * std::tan(chi) - 0.2155 * t + 2.4192);
}

// Cubic in the sun's zenith angle, multiplied by the powers of T.
double zenith_chromaticity(const double (&m)[3][4], double t, double s) {
  const auto cubic = [s](const double(&k)[4]) { return ((k[0] * s + k[1]) * s + k[2]) * s + k[3]; };
  return (cubic(m[0]) * t + cubic(m[1])) * t + cubic(m[2]);
}
// Preetham 1999, appendix A.2.
constexpr double kZenithX[3][4] = {
    {.00166, -.00375, .00209, 0.0}, {-.02903, .06377, -.03202, .00394}, {.11693, -.21196, .06052, .25886}};
constexpr double kZenithY[3][4] = {
    {.00275, -.00610, .00317, 0.0}, {-.04214, .08970, -.04153, .00516}, {.15346, -.26756, .06670, .26688}};

}  // namespace

PerezCoefficients perez_slopes(PerezQuantity quantity) {
  return table_of(quantity).slope;
}

PerezCoefficients perez_coefficients(PerezQuantity quantity, Turbidity turbidity) {
  const auto& [slope, offset] = table_of(quantity);
  const double t = turbidity.value;
  return {slope.a * t + offset.a, slope.b * t + offset.b, slope.c * t + offset.c, slope.d * t + offset.d,
          slope.e * t + offset.e};
}

double clamp_cosine(double cosine) {
  return std::clamp(cosine, kSmallestCosine, 1.0);
}

double perez(const PerezCoefficients& k, double cos_theta, Radians gamma) {
  const double cos_gamma = std::cos(gamma.value);
  return (1.0 + k.a * std::exp(k.b / clamp_cosine(cos_theta))) *
         (1.0 + k.c * std::exp(k.d * gamma.value) + k.e * cos_gamma * cos_gamma);
}

Turbidity clamp_turbidity(Turbidity turbidity) {
  return std::clamp(turbidity, kLowestTurbidity, kHighestTurbidity);
}

PreethamSky::PreethamSky(Turbidity turbidity, const SunDirection& sun)
    : turbidity_(clamp_turbidity(turbidity)),
      sun_(sun),
      luminance_(perez_coefficients(PerezQuantity::luminance, turbidity_)),
      x_(perez_coefficients(PerezQuantity::x, turbidity_)),
      y_(perez_coefficients(PerezQuantity::y, turbidity_)) {
  const Radians sun_zenith = zenith_angle(sun);
  const double t = turbidity_.value;
  zenith_ = {zenith_luminance_kcd(t, sun_zenith.value), zenith_chromaticity(kZenithX, t, sun_zenith.value),
             zenith_chromaticity(kZenithY, t, sun_zenith.value)};
  at_zenith_ = {perez(luminance_, 1.0, sun_zenith), perez(x_, 1.0, sun_zenith), perez(y_, 1.0, sun_zenith)};
}

double PreethamSky::luminance_ratio(double cos_theta, Radians gamma) const {
  return perez(luminance_, cos_theta, gamma) / at_zenith_.x;
}

double PreethamSky::luminance_ratio(const Direction& view) const {
  return luminance_ratio(view.z, angle_between(view, sun_));
}

glm::dvec3 PreethamSky::luminance_and_chromaticity(const Direction& view) const {
  const Radians gamma = angle_between(view, sun_);
  return zenith_ * glm::dvec3{perez(luminance_, view.z, gamma), perez(x_, view.z, gamma), perez(y_, view.z, gamma)} /
         at_zenith_;
}

glm::dvec3 PreethamSky::xyz(const Direction& view) const {
  return xyz_of(luminance_and_chromaticity(view));
}

glm::dvec3 PreethamSky::relative_xyz(const Direction& view) const {
  const Radians gamma = angle_between(view, sun_);
  const glm::dvec3 of_view{perez(luminance_, view.z, gamma), perez(x_, view.z, gamma), perez(y_, view.z, gamma)};
  const glm::dvec3 absolute = zenith_ * of_view / at_zenith_;
  return xyz_of({of_view.x / at_zenith_.x, absolute.y, absolute.z});
}

glm::dvec3 xyz_of(const glm::dvec3& luminance_and_chromaticity) {
  const double luminance = luminance_and_chromaticity.x;
  const double x = luminance_and_chromaticity.y, y = luminance_and_chromaticity.z;
  return {luminance * x / y, luminance, luminance * (1.0 - x - y) / y};
}

}  // namespace kasumi
