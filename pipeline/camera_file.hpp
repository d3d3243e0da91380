// A description of cameras by itself, without a building: for commands that work on pictures at hand.
#pragma once

#include <filesystem>
#include <optional>

#include "base/result.hpp"
#include "calib/camera.hpp"

namespace kasumi {

struct CameraFile {
  std::optional<Camera> scene, sky;
  std::optional<Site> site;
};

// [scene] and, if wanted, [sky], [site] (docs/cameras.md), with the calibration file they name beneath them. What
// `kasumi calibrate` wrote serves, and so does a fixture's description as it is. Errors (bad_input): every problem.
Result<CameraFile> read_camera_file(const std::filesystem::path& file);

}  // namespace kasumi
