// What several steps of `kasumi calibrate` begin with: a recording, and what is calibrated of its camera by now.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "capture/frame.hpp"
#include "pipeline/fixture_file.hpp"

namespace kasumi {

// [sky] or [scene] of a recording, and what the calibration file already says in its place. Errors (bad_input): the
// file is no calibration file, is of pictures of another size, or what the two say together makes no camera.
Result<Camera> calibrated_camera(const Fixture& fixture, const std::filesystem::path& calibration,
                                 const std::string& camera);

struct PicturesRead {
  int good = 0, damaged = 0;
  Utc first{}, last{};  // of the good ones
};
// Hands over at most `most` pictures of a recorded camera, evenly spread over its rows. Errors: those of the recording;
// bad_input when no picture of it can be read.
Result<PicturesRead> look_through(const Fixture& fixture, const Camera& camera, int most,
                                  const std::function<void(const PictureView&, Utc)>& look);

// A file of a person's is not lost: what is there under this name is copied to NAME.1.old, NAME.2.old, ...
// Returns the copy's name; empty when nothing was there.
Result<std::optional<std::filesystem::path>> keep_old(const std::filesystem::path& path);

// calibration.CAMERA-WHAT beside calibration.toml.
std::filesystem::path beside(const std::filesystem::path& calibration, const std::string& what);

}  // namespace kasumi
