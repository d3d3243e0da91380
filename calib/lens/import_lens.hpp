// Lens calibrations of other programs.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "base/result.hpp"
#include "calib/lens/lens_description.hpp"

namespace kasumi {

struct ImportedLens {
  LensDescription lens;  // largest_angle: as asked for, else 90 deg or as far as the picture reaches
  int width = 0;
  int height = 0;
  std::string program;           // "OCamCalib", "OpenCV", "ROS", "Kalibr", "COLMAP", "Agisoft", "Hugin"
  std::string foreign_model;     // as that program names it; empty: it has one only
  double moved_px = 0.0;         // by how much our model differs from that program's, at most
  std::optional<double> rms_px;  // as that program reported it
};

struct ImportRequest {
  std::string model = "auto";              // one of our models' names; it decides where the file leaves it open
  std::optional<Radians> largest_angle{};  // of a fisheye
  std::string camera{};  // of several: COLMAP's number, Kalibr's name, topic or number; empty: the only one
};

// By content, not by name: OCamCalib's calib_results.txt; OpenCV's .yml, .xml and .json of pinhole, fisheye and
// omnidir; ROS' camera_info; Kalibr's camchain; ORB-SLAM's settings; COLMAP's cameras.txt; Agisoft's calibration;
// Hugin's .pto. Errors (bad_input): everything wrong with it; a number whose meaning is not known; a model that no lens
// model of Kasumi follows within .1 px; several cameras and none is chosen, with a list of them; `model`,
// `largest_angle` or `camera` without effect.
Result<ImportedLens> import_lens(const std::filesystem::path& path, const ImportRequest& options = {});

}  // namespace kasumi
