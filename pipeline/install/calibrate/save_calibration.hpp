// How every step of `kasumi calibrate` saves its results: the calibration file and files next to it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "base/picture.hpp"
#include "base/result.hpp"
#include "calib/calibration_file.hpp"

namespace kasumi {

// Writes the step into the calibration file and then its plot next to it (drawing_name, after the first of
// step.measured, under which it is noted), and says so. A step that the file does not take leaves the older drawing as
// it is. Returns exit code 0. Errors: bad_input, io.
Result<int> save_calibration(const std::filesystem::path& calibration, CalibrationStep step,
                             const Image<Rgb8>& drawing);

// Keeps a file that a person may have edited: copies it to NAME.1.old, NAME.2.old, ...
// Returns the copy's name; empty when nothing was there.
Result<std::optional<std::filesystem::path>> keep_old(const std::filesystem::path& path);

// calibration.CAMERA-WHAT next to calibration.toml.
std::filesystem::path beside(const std::filesystem::path& calibration, const std::string& what);

}  // namespace kasumi
