// Files that describe cameras or landmarks by themselves, without a building: for commands that work on pictures at
// hand.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "base/result.hpp"
#include "calib/camera.hpp"
#include "estimator/landmarks/contrast.hpp"

namespace kasumi {

struct CameraFile {
  std::optional<Camera> scene, sky;
  std::optional<Site> site;
};

// [scene] and, if wanted, [sky], [site] (docs/cameras.md), with the calibration file they name beneath them. What
// `kasumi calibrate` wrote serves, and so does a fixture's description as it is. Errors (bad_input): every problem.
Result<CameraFile> read_camera_file(const std::filesystem::path& file);

struct LandmarkFile {
  std::optional<Camera> scene;  // [scene]; else an ordinary camera, sRGB
  double altitude_m = 0.0;      // of [site]
  std::vector<ContrastLandmark> landmarks;
};
// A list of [[landmarks]] by itself, with [scene] and [site] where known; a fixture's description and a kiosk's
// configuration serve as they are. `width`, `height`: of the pictures. Errors (bad_input): every problem at once.
Result<LandmarkFile> read_landmark_file(const std::filesystem::path& path, int width, int height);

}  // namespace kasumi
