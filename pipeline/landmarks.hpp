// Things that anybody can see from the site and find on a map: where the overlay says they should stand, they do, or
// the camera's heading is wrong.
#pragma once

#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "base/config_table.hpp"
#include "calib/camera.hpp"

namespace kasumi {

struct Landmark {
  std::string name;
  glm::dvec3 place_m{};  // east, north, up as seen from the site: the earth's curvature and refraction are in it
};

// [[landmarks]]: name, latitude_deg, longitude_deg, altitude_m; those that tell their distance_m alone are not among
// them. Problems are left in the root's file.
std::vector<Landmark> read_landmarks(const ConfigTable& root, const Site& site);

}  // namespace kasumi
