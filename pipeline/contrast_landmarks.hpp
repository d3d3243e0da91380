// Landmarks that tell the visibility: how far they are, and where the scene camera's picture shows them.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "base/config_table.hpp"
#include "calib/camera.hpp"
#include "estimator/landmark_contrast.hpp"

namespace kasumi {

// Those of [[landmarks]] that have a region_px (docs/operating.md lists their keys). Without a site they must say
// distance_m themselves. Problems are left in the root's file.
std::vector<ContrastLandmark> read_contrast_landmarks(const ConfigTable& root, const std::optional<Site>& site,
                                                      int width, int height);

// A file of landmarks for pictures at hand.
struct LandmarkFile {
  std::optional<Camera> scene;  // [scene]; else an ordinary camera, sRGB
  double altitude_m = 0.0;      // of [site]
  std::vector<ContrastLandmark> landmarks;
};
// A list of [[landmarks]] by itself, with [scene] and [site] where known; a fixture's description and a kiosk's
// configuration serve as they are. `width`, `height`: of the pictures. Errors (bad_input): every problem at once.
Result<LandmarkFile> read_landmark_file(const std::filesystem::path& path, int width, int height);

}  // namespace kasumi
