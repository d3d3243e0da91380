#include "estimator/dome.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>
#include <glm/geometric.hpp>

#include "estimator/sky_model.hpp"

namespace kasumi {
namespace {

constexpr double kEarthRadius_m = 6371000.0;
constexpr int kTerms = kDomeAngles * kDomePowers;

double lobe(double asymmetry, double cos_gamma) {
  const double q = (1.0 - asymmetry) * (1.0 - asymmetry) / (1.0 + asymmetry * asymmetry - 2.0 * asymmetry * cos_gamma);
  return q * std::sqrt(q);
}

// The terms in the order of the coefficients.
Eigen::Matrix<double, kTerms, 1> terms(const DomeFunction& sky, const Direction& view) {
  const double h = sky.horizon_sine, m = std::max(0.0, (view.z - h) / (1.0 - h)),
               u = 1.0 / (1.0 + double{sky.steepness} * m);
  const double g = glm::dot(view, glm::dvec3(sky.sun));
  const double angles[kDomeAngles] = {1.0, g, g * g, lobe(sky.lobes.x, g), lobe(sky.lobes.y, g), lobe(sky.lobes.z, g)};
  Eigen::Matrix<double, kTerms, 1> all;
  for (int j = 0; j < kDomeAngles; ++j)
    for (int k = 0; k < kDomePowers; ++k) all[j * kDomePowers + k] = angles[j] * std::pow(u, k);
  return all;
}

}  // namespace

double horizon_sine(double altitude_m) {
  const double q = kEarthRadius_m / (kEarthRadius_m + std::max(altitude_m, 0.0));
  return -std::sqrt(1.0 - q * q);
}

// Provisional: Preetham's sky, dimmed with altitude, until the table is there.
DomeFunction dome(double altitude_m, Turbidity turbidity, const SunDirection& sun) {
  DomeFunction sky;
  sky.sun = glm::vec3(sun);
  sky.horizon_sine = static_cast<float>(horizon_sine(altitude_m));
  sky.steepness = 6.0F;
  sky.lobes = {0.8F, 0.5F, -0.45F};
  const Radians zenith{std::min(zenith_angle(sun).value, from_degrees(86.0).value)};
  const SkyModel model(turbidity, direction_from(zenith, azimuth_angle(sun)));
  Eigen::MatrixXd a(31 * 24, kTerms);
  Eigen::MatrixXd b(31 * 24, 3);
  for (int row = 0; row < a.rows(); ++row) {
    const Direction view = direction_from(from_degrees(0.5 + 2.9 * (row / 24)), from_degrees(15.0 * (row % 24)));
    const glm::dvec3 light = 1000.0 * model.xyz(view) * std::exp(-altitude_m / 8000.0);
    const double weight = 1.0 / std::max(light.y, 1.0);
    a.row(row) = weight * terms(sky, view).transpose();
    for (int c = 0; c < 3; ++c) b(row, c) = weight * light[c];
  }
  const Eigen::MatrixXd normal = a.transpose() * a + 1e-7 * Eigen::MatrixXd::Identity(kTerms, kTerms);
  const Eigen::MatrixXd x = normal.ldlt().solve(a.transpose() * b);
  for (int k = 0; k < kTerms; ++k) sky.coefficients[k] = glm::vec3(x(k, 0), x(k, 1), x(k, 2));
  return sky;
}

SunLight dome_sun(double altitude_m, Turbidity turbidity, const SunDirection& sun) {
  const double left = sun.z <= horizon_sine(altitude_m)
                          ? 0.0
                          : std::exp(-(0.1 + 0.1 * (turbidity.value - 1.0)) / std::max(sun.z, 0.026));
  const glm::dvec3 illuminance = 128000.0 * left * glm::dvec3(0.97, 1.0, 0.95);
  const double radius = kSunRadius_rad;
  return {illuminance, illuminance / (kPi * radius * radius)};
}

DomeFunction in_space(DomeFunction sky, const glm::dmat3& xyz_to_space) {
  for (glm::vec3& c : sky.coefficients) c = glm::vec3(xyz_to_space * glm::dvec3(c));
  return sky;
}

glm::dmat3 xyz_to_linear_srgb() {
  return {3.2406, -0.9689, 0.0557, -1.5372, 1.8758, -0.2040, -0.4986, 0.0415, 1.0570};
}

glm::dvec3 dome_light(const DomeFunction& sky, const Direction& view) {
  const Eigen::Matrix<double, kTerms, 1> all = terms(sky, view);
  glm::dvec3 light{0};
  for (int k = 0; k < kTerms; ++k) light += all[k] * glm::dvec3(sky.coefficients[k]);
  return glm::max(light, glm::dvec3(0.0));
}

}  // namespace kasumi
