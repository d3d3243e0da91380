// Records both live cameras as a fixture and shows a notice on the display.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>

#include "pipeline/lab/recording/recording.hpp"
#include "pipeline/machine/devices.hpp"

namespace kasumi {

struct RecordRequest {
  std::filesystem::path config;  // kasumi.toml
  std::filesystem::path folder;  // created; holds the fixture
  Duration length = std::chrono::seconds(60);
  Duration every{};  // at most one frame of each camera in this time; 0: every frame
  RecordingLimits limits;
};

struct RecordedStream {
  int rows = 0;  // frames and outages
  CameraHealth health;
};

struct RecordSummary {
  RecordedStream sky, scene;
  std::uint64_t bytes = 0;
  Duration lasted{};
  std::string ended;   // why: "60 s recorded"
  bool whole = false;  // it ended as planned, and both cameras have frames
};

// BLOCKS until a limit is reached or `stop` returns true. Whatever is on the disk by then can be replayed.
// Errors: bad_input (configuration; a recording is there already), io (the folder), and those of opening the display:
// visitors are never recorded without a notice. If the display is lost later, recording goes on while it is reopened.
Result<RecordSummary> record(const RecordRequest& request, Devices& devices, Clock& clock,
                             const std::function<bool()>& stop);

}  // namespace kasumi
