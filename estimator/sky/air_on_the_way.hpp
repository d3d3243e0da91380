// What the two skies that bracket a path leave out of the air between them (base/sky/dome.glsl): how far the skies on
// the way differ from interpolated ones, and what haze there scatters of light that comes from below.
#pragma once

#include <array>
#include <functional>

#include <glm/vec3.hpp>

#include "base/sky/dome_scene.hpp"

namespace kasumi {

// The sky at an altitude, in the scene's colours.
using DomeAtAltitude = std::function<DomeFunction(double altitude_m)>;

// DomeScene::departures and departures_sun. The scene must have the two skies and the air.
struct Departures {
  std::array<glm::dvec3, 4> even{}, sun{};
};
Departures departures_on_the_way(const DomeScene& scene, const DomeAtAltitude& sky_at);

// DomeScene::below and below_steep, over plain land of the given light. The scene must have all the rest, haze included.
struct LightFromBelow {
  std::array<glm::dvec3, 3> even{}, steep{};
};
LightFromBelow light_from_below(const DomeScene& scene, const DomeAtAltitude& sky_at, const glm::dvec3& land);

}  // namespace kasumi
