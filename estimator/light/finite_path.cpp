#include "estimator/light/finite_path.hpp"

#include <cmath>

#include <glm/common.hpp>
#include <glm/exponential.hpp>

namespace kasumi {
namespace {

// The sky's logarithm is taken as a straight line over the few hundred metres that a site's paths rise or fall.
constexpr double kStep_m = 300.0;
// A path that takes less adds nothing that could be seen.
constexpr double kLeastTaken = 1e-4;

}  // namespace

FinitePath::FinitePath(const SiteSky& sky, const AirState& air, const SunDirection& sun, double altitude_m,
                       const glm::dmat3& xyz_to_light)
    : dome_share_(sky.dome_share()), xyz_to_light_(xyz_to_light) {
  if (dome_share_ <= 0.0) return;
  here_ = dome(altitude_m, air.aerosol(), sun);
  higher_ = dome(altitude_m + kStep_m, air.aerosol(), sun);
}

glm::dvec3 FinitePath::factor(const Direction& direction, double rise_m, const glm::dvec3& gamma) const {
  if (dome_share_ <= 0.0) return glm::dvec3{1.0};
  const glm::dvec3 here = xyz_to_light_ * dome_light(here_, direction);
  const glm::dvec3 higher = xyz_to_light_ * dome_light(higher_, direction);
  glm::dvec3 factor{1.0};
  for (int c = 0; c < 3; ++c) {
    const double taken = 1.0 - gamma[c];
    if (!(here[c] > 0.0) || !(higher[c] > 0.0) || !(taken > kLeastTaken)) continue;
    const double at_end = std::pow(higher[c] / here[c], rise_m / kStep_m);
    factor[c] = glm::clamp((1.0 - gamma[c] * at_end) / taken, 0.5, 1.5);
  }
  return glm::mix(glm::dvec3{1.0}, factor, dome_share_);
}

}  // namespace kasumi
