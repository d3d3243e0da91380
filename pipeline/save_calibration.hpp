// The last thing every step of `kasumi calibrate` does.
#pragma once

#include <filesystem>

#include "base/picture.hpp"
#include "base/result.hpp"
#include "calib/calibration_file.hpp"

namespace kasumi {

// Writes the step into the calibration file and then what it drew beside it (drawing_name, after the first of
// step.measured, under which it is noted), and says so. A step that the file does not take leaves the older drawing as
// it is. Returns exit code 0. Errors: bad_input, io.
Result<int> save_calibration(const std::filesystem::path& calibration, CalibrationStep step,
                             const Image<Rgb8>& drawing);

}  // namespace kasumi
