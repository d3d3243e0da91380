// Files that describe only cameras or landmarks, without a building: for commands that work on given pictures.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "base/result.hpp"
#include "calib/camera.hpp"
#include "estimator/landmarks/contrast.hpp"

namespace kasumi {

struct CalibrationContents {
  std::optional<Camera> scene, sky;
  std::optional<Site> site;
};

// [scene] and, if wanted, [sky], [site] (docs/cameras.md), on top of the calibration file they name. Accepts
// what `kasumi calibrate` wrote and a fixture's description. Errors (bad_input): all problems.
Result<CalibrationContents> read_camera_file(const std::filesystem::path& file);

struct LandmarkFile {
  std::optional<Camera> scene;  // [scene]; empty: an ordinary sRGB camera
  double altitude_m = 0.0;      // of [site]
  std::optional<Site> site{};
  std::vector<ContrastLandmark> landmarks;
};
// A list of [[landmarks]], with optional [scene] and [site]; a fixture's description and a kiosk's configuration are
// accepted too. `width`, `height`: of the pictures. Errors (bad_input): all problems at once.
Result<LandmarkFile> read_landmark_file(const std::filesystem::path& path, int width, int height);

}  // namespace kasumi
