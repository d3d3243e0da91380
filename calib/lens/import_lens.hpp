// Lens calibrations of other programs.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "base/result.hpp"
#include "calib/lens/lens_description.hpp"

namespace kasumi {

struct ImportedLens {
  LensDescription lens;  // largest_angle: 90 deg, which the files do not state
  int width = 0;
  int height = 0;
  std::string program;           // "OCamCalib", "OpenCV"
  std::optional<double> rms_px;  // as that program reported it
};

// OCamCalib's calib_results.txt; OpenCV's .yml, .yaml, .xml or .json as its samples and most tools write it: a 3 x 3
// matrix camera_matrix (or cameraMatrix, K), distortion_coefficients (or distCoeffs, D), image_width and image_height,
// fisheye_model = 1 (or distortion_model: equidistant, fisheye) for the fisheye. Errors (bad_input): everything wrong
// with it.
Result<ImportedLens> import_lens(const std::filesystem::path& path);

}  // namespace kasumi
