// Where frames come from: a camera, or a recording that behaves like one.
#pragma once

#include <memory>
#include <string>

#include "base/clock.hpp"
#include "base/result.hpp"
#include "capture/frame.hpp"

namespace kasumi {

class FrameSource {
 public:
  virtual ~FrameSource() = default;
  virtual std::string description() const = 0;  // "fixture clear-noon, sky camera"
  // BLOCKS until a frame arrives or the deadline passes. Damaged frames are delivered with their status, for the reader
  // to skip and count. Errors: timeout (no frame yet; try again), disconnected (reopen the source), end_of_stream (a
  // recording has ended).
  virtual Result<Frame> next(Instant deadline) = 0;
};

}  // namespace kasumi
