// Records both live cameras as a fixture, and shows on the display that it does.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>

#include "pipeline/machine/devices.hpp"
#include "pipeline/recording/recording.hpp"

namespace kasumi {

struct RecordRequest {
  std::filesystem::path config;  // kasumi.toml
  std::filesystem::path folder;  // made; holds the fixture
  Duration length = std::chrono::seconds(60);
  Duration every{};  // of each camera at most one frame in this time; 0: every frame
  RecordingLimits limits;
};

struct RecordedCamera {
  int rows = 0;  // frames and outages
  CameraHealth health;
};

struct RecordSummary {
  RecordedCamera sky, scene;
  std::uint64_t bytes = 0;
  Duration lasted{};
  std::string ended;   // why: "60 s are recorded"
  bool whole = false;  // it ended as it was meant to, and both cameras have frames
};

// BLOCKS until a limit is reached or `stop` answers true. Whatever is on the disk by then replays.
// Errors: bad_input (configuration; a recording is there already), io (the folder), and whatever the display says when
// it cannot be opened: nobody is recorded without being told. One that goes away later is waited for while recording.
Result<RecordSummary> record(const RecordRequest& request, Devices& devices, Clock& clock,
                             const std::function<bool()>& stop);

}  // namespace kasumi
