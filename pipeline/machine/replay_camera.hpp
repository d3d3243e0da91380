// A recording that stands in for a live camera: played in a loop, with the disconnections it recorded.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>

#include "capture/fixture/replay_source.hpp"
#include "capture/reconnecting_source.hpp"

namespace kasumi {

// The recording keeps running while the camera is closed and reopened, as the world in front of a live camera does:
// frames due meanwhile are skipped. Frames are stamped with the clock's time at which they were due, so that their age
// is right. `recording` is called when the camera is first opened.
SourceOpener replay_camera(std::string name, std::function<Result<std::shared_ptr<ReplaySource>>()> recording,
                           Clock& clock);

// The median interval between frames of a recording; 0 when it has fewer than two or cannot be read.
Duration median_interval(const std::filesystem::path& camera_folder);

}  // namespace kasumi
