// What several steps of `kasumi calibrate` begin with: what is calibrated of a recording's camera by now.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "pipeline/fixture_file.hpp"

namespace kasumi {

// [sky] or [scene] of a recording, and what the calibration file already says in its place. Errors (bad_input): the
// file is no calibration file, is of pictures of another size, or what the two say together makes no camera.
Result<Camera> calibrated_camera(const Fixture& fixture, const std::filesystem::path& calibration,
                                 const std::string& camera);

// A file of a person's is not lost: what is there under this name is copied to NAME.1.old, NAME.2.old, ...
// Returns the copy's name; empty when nothing was there.
Result<std::optional<std::filesystem::path>> keep_old(const std::filesystem::path& path);

// calibration.CAMERA-WHAT beside calibration.toml.
std::filesystem::path beside(const std::filesystem::path& calibration, const std::string& what);

}  // namespace kasumi
