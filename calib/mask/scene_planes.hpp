// Distances without a depth map: level ground below the camera and vertical walls.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "base/image.hpp"
#include "base/result.hpp"
#include "calib/camera.hpp"

namespace kasumi {

// Upright, endless to both sides within its azimuths: a row of houses, a wood, a ridge.
struct SceneWall {
  double distance_m = 0.0;          // to it along `faces`
  Radians faces;                    // azimuth of its nearest point: the wall runs at right angles to it
  std::optional<Radians> from, to;  // azimuths between which it stands, clockwise; empty: all
  std::optional<double> top_m;      // over the camera; empty: as high as the picture's sky begins
};

struct ScenePlanes {
  std::optional<double> camera_height_m;  // over level ground; empty: no ground is seen
  std::vector<SceneWall> walls;
  // A wall without a top hides the sky until the picture says where it is.
  bool sky_from_picture() const;
};

// docs/photographs.md describes it. Errors (bad_input): every problem of it at once.
Result<ScenePlanes> read_scene_planes(const std::filesystem::path& path);

// Along each pixel's line of sight to whatever is nearest; 0: sky.
Image<float> distances_to(const ScenePlanes& planes, const Camera& camera);

}  // namespace kasumi
