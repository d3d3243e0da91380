// The input of `kasumi calibrate scene`: places on the map and their pixels in the picture.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "calib/camera.hpp"
#include "calib/pose/scene_pose.hpp"

namespace kasumi {

struct SceneSights {
  Site site;
  int width = 0;
  int height = 0;
  LensDescription lens;                  // a pinhole's
  std::optional<std::string> response;   // of [scene], if given: "srgb" or "linear"
  double refraction = 0.13;              // coefficient of refraction
  std::vector<LandmarkSight> landmarks;  // and, at the end, the sun each time it was seen
  std::vector<HorizonSight> horizon;
};

// What the calibration file already contains, so that the sights need not repeat it.
struct KnownCalibration {
  std::optional<Site> site;
  int width = 0;
  int height = 0;
  std::optional<LensDescription> lens;
  std::optional<double> focal_sigma;  // relative; of a lens that was measured
};
// Empty where there is no such file yet. Errors (bad_input): it is not a calibration file.
Result<KnownCalibration> read_calibrated_scene(const std::filesystem::path& calibration);

// "12.34 km"; of the sun nothing.
std::string distance_text(const LandmarkSight& sight);

// docs/calibration.md describes it. Errors (bad_input): every problem of it at once.
Result<SceneSights> read_scene_sights(const std::filesystem::path& path, const KnownCalibration& calibrated);

}  // namespace kasumi
