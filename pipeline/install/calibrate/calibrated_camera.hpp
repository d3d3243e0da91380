// Where several steps of `kasumi calibrate` start: a recording's camera as calibrated so far.
#pragma once

#include <filesystem>
#include <string>

#include "pipeline/site/config/fixture_file.hpp"

namespace kasumi {

// [sky] or [scene] of a recording, overridden by the calibration file. Errors (bad_input): the
// file is no calibration file, is of pictures of another size, or what the two say together makes no camera.
Result<Camera> calibrated_camera(const Fixture& fixture, const std::filesystem::path& calibration,
                                 const std::string& camera);

}  // namespace kasumi
