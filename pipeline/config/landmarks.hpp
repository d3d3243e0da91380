// Things visible from the site whose position a map gives: [[landmarks]] of a fixture or configuration.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "base/config_table.hpp"
#include "calib/camera.hpp"
#include "estimator/landmarks/contrast.hpp"

namespace kasumi {

// The overlay marks where it should appear: if it does not, the camera's orientation is wrong.
struct Landmark {
  std::string name;
  glm::dvec3 place_m{};  // east, north, up from the site, with the earth's curvature and refraction
};

// [[landmarks]] with name, latitude_deg, longitude_deg, altitude_m; those that give only distance_m are skipped.
// Problems are collected in the root's file.
std::vector<Landmark> read_landmarks(const ConfigTable& root, const Site& site);

// The landmarks that measure visibility, by their distance and their place in the scene camera's picture: all with a
// region_px (docs/operating.md lists their keys). Without a site they must give distance_m. Problems are collected in
// the root's file.
std::vector<ContrastLandmark> read_contrast_landmarks(const ConfigTable& root, const std::optional<Site>& site,
                                                      int width, int height);

}  // namespace kasumi
