// Logs the mode that the driver chose, when it differs from the last time: a camera that streams nothing is opened some
// 4,500 times a day.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "capture/camera_source.hpp"

namespace kasumi {

class ModeLog {
 public:
  explicit ModeLog(std::string name) : name_(std::move(name)) {}
  // What opening the camera gave, as it is.
  Result<std::unique_ptr<FrameSource>> operator()(Result<std::unique_ptr<CameraSource>> opened);

 private:
  std::string name_;
  std::vector<std::string> said_;
};

}  // namespace kasumi
