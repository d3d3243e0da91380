// The sun's place as the centre of a sky that grows dimmer with the distance from it.
#pragma once

#include <optional>

#include "estimator/atmosphere.hpp"
#include "estimator/sky_camera/sky_slopes.hpp"

namespace kasumi {

struct AureoleFit {
  SunDirection centre{0.0, 0.0, 1.0};
  Radians sigma;           // one axis; from sectors left out in turn
  Radians hole;            // of a cap with the solid angle of what is clipped around the centre
  Radians rim;             // from there on light is compared
  double explained = 0.0;  // 0..1: share of the places that follow it
  double fall = 0.0;       // -d ln light / d ln distance just outside the hole
  double rise = 0.0;       // ln light: from 10 deg further out to the hole's rim
  double above = 0.0;      // ln light: of the rim over the middle of the whole sky
  double clipped = 1.0;    // share of all that is clipped in the sky that belongs to the hole
};

// ln light = a function of the distance from the sun + a slope, a saddle and a bend of the sky, in the plane that
// touches the sphere there: least squares with Tukey's weights. Where the picture is clipped, light may be more than is
// seen.
// reach: as far from the hole's rim as its radius times .wide, and .further.
struct AureoleReach {
  double wide = 1.0;
  Radians further = from_degrees(10.0);
  bool held = false;          // the centre stays where it is
  bool less_horizon = false;  // without what a clear sky adds towards the horizon, which moves the centre there
};
std::optional<AureoleFit> fit_aureole(const CoarseMaps& sky, const SunDirection& start, const AureoleReach& reach = {});

}  // namespace kasumi
