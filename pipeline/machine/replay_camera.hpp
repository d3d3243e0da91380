// A recording that stands in for a live camera: played over and over, gone where the recording says so, and back.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>

#include "capture/fixture/replay_source.hpp"
#include "capture/reconnecting_source.hpp"

namespace kasumi {

// The recording runs on while the camera is torn down and opened again, as the world does before a live one: what
// passed meanwhile is not seen. Frames are stamped with the clock's time at which they were due, so that their age can
// be told. `recording` is asked when the camera is first opened.
SourceOpener replay_camera(std::string name, std::function<Result<std::shared_ptr<ReplaySource>>()> recording,
                           Clock& clock);

// Between two frames of a recording, the median; 0 when there are fewer than two or it cannot be read.
Duration median_interval(const std::filesystem::path& camera_folder);

}  // namespace kasumi
