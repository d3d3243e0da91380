// Directions in the world frame: x east, y north, z up. Zenith angle from +z; azimuth clockwise from true north.
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "base/units.hpp"

namespace kasumi {

using Direction = glm::dvec3;  // a unit vector, world frame

Direction direction_from(Radians zenith, Radians azimuth);
Radians zenith_angle(const Direction& direction);                 // 0 .. pi
Radians azimuth_angle(const Direction& direction);                // 0 .. 2 pi, 0 for the zenith itself
Radians angle_between(const glm::dvec3& a, const glm::dvec3& b);  // exact for tiny angles; need not be unit vectors

// Raises a direction below the horizon to the horizon at its azimuth (straight down: to the north); leaves others as
// they are. For models that are undefined below the horizon.
Direction raised_to_horizon(const Direction& direction);

// Camera frame: x right, y down, z along the optical axis. Columns of the result are the camera's axes in the world
// frame, so world = R * camera. heading: azimuth of the optical axis; pitch: its elevation above the horizon; roll:
// clockwise turn of the camera about its axis as seen from behind it. With pitch 90 deg the top of the image lies at
// azimuth heading + 180 deg, and azimuth grows counter-clockwise in the image, as a camera looking up sees it.
glm::dmat3 camera_to_world(Radians heading, Radians pitch, Radians roll);

}  // namespace kasumi
