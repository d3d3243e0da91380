// Things that anybody can see from the site and find on a map: [[landmarks]] of a fixture or configuration.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "base/config_table.hpp"
#include "calib/camera.hpp"
#include "estimator/landmarks/contrast.hpp"

namespace kasumi {

// Where the overlay says they should stand, they do, or the camera's heading is wrong.
struct Landmark {
  std::string name;
  glm::dvec3 place_m{};  // east, north, up as seen from the site: the earth's curvature and refraction are in it
};

// [[landmarks]]: name, latitude_deg, longitude_deg, altitude_m; those that tell their distance_m alone are not among
// them. Problems are left in the root's file.
std::vector<Landmark> read_landmarks(const ConfigTable& root, const Site& site);

// Those that tell the visibility, by how far they are and where the scene camera's picture shows them: all with a
// region_px (docs/operating.md lists their keys). Without a site they must say distance_m themselves. Problems are left
// in the root's file.
std::vector<ContrastLandmark> read_contrast_landmarks(const ConfigTable& root, const std::optional<Site>& site,
                                                      int width, int height);

}  // namespace kasumi
