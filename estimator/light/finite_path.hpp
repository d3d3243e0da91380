// Light that the air before an object adds, where that air is not lit evenly: near the horizon under a low sun, the air
// of the first kilometres is darker than what lies behind and above it.
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "base/geometry.hpp"
#include "estimator/atmosphere.hpp"
#include "estimator/sky/dome.hpp"
#include "estimator/sky/site_sky.hpp"

namespace kasumi {

// M Eq 12 takes Linf (1 - Gamma). Where air is the same at the same height, the air between two heights adds exactly
// L(h0) - Gamma L(h1), L being the sky's light in the same direction (docs/sky.md). This is the one over the other.
class FinitePath {
 public:
  // xyz_to_light: inverse of Camera::light_to_xyz. `sky`: the site's, at altitude_m; where it is Preetham's, which knows
  // no altitude, the factor is 1, and in between where the two are blended.
  FinitePath(const SiteSky& sky, const AirState& air, const SunDirection& sun, double altitude_m,
             const glm::dmat3& xyz_to_light);

  // For each channel, 0.5 to 1.5. `gamma`: what the path lets through. `rise_m`: of its end above its beginning.
  glm::dvec3 factor(const Direction& direction, double rise_m, const glm::dvec3& gamma) const;

 private:
  double dome_share_;
  DomeFunction here_, higher_;
  glm::dmat3 xyz_to_light_;
};

}  // namespace kasumi
