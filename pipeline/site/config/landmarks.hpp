// Things visible from the site whose position a map gives: [[landmarks]] of a fixture or configuration.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "base/image.hpp"
#include "base/table/config_table.hpp"
#include "calib/camera.hpp"
#include "estimator/landmarks/contrast.hpp"

namespace kasumi {

// The overlay marks where it should appear: if it does not, the camera's orientation is wrong.
struct Landmark {
  std::string name;
  glm::dvec3 place_m{};  // east, north, up from the site, with the earth's curvature and refraction
};

// [[landmarks]] with name, latitude_deg, longitude_deg, altitude_m; those that give no place are skipped. Problems are
// collected in the root's file.
std::vector<Landmark> read_landmarks(const ConfigTable& root, const Site& site);

// What is known of the scene camera's picture.
struct LandmarkContext {
  int width = 0, height = 0;
  const Camera* camera = nullptr;             // its heading is; null: not
  const Image<float>* distances_m = nullptr;  // [scene] depth_map; null or empty: there is none
};

// The landmarks that measure visibility, by their distance and their place in the scene camera's picture: all with a
// region_px, a ridge_px or from_depth_map (docs/operating.md lists their keys). Without a site and a depth map they must
// give distance_m. Problems are collected in the root's file.
std::vector<ContrastLandmark> read_contrast_landmarks(const ConfigTable& root, const std::optional<Site>& site,
                                                      const LandmarkContext& scene);

}  // namespace kasumi
