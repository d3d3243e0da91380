// The system calls a V4L2 device is driven by: a boundary that tests can stand behind.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "base/clock.hpp"
#include "base/result.hpp"

namespace kasumi {

struct VideoEvents {
  bool readable = false;  // a buffer can be dequeued
  bool event = false;     // an event can be dequeued
  bool error = false;     // the queue has failed, or the device is gone
};

class VideoDevice {
 public:
  virtual ~VideoDevice() = default;  // closes
  // ioctl(2): 0, or the errno. Never blocks for a frame. From any thread, several at a time.
  virtual int control(unsigned long request, void* argument) = 0;
  // poll(2): BLOCKS until there is something or `longest` has passed; may return early with nothing.
  virtual VideoEvents wait(Duration longest) = 0;
  // mmap(2), to read only: empty and `error` (errno) when refused.
  virtual std::span<const std::uint8_t> map(std::size_t length, std::int64_t offset, int& error) = 0;
  virtual void unmap(std::span<const std::uint8_t> mapped) = 0;
};

// Errors: disconnected (no such file), device (everything else open(2) refuses), unsupported (not a character device).
Result<std::unique_ptr<VideoDevice>> open_video_device(const std::filesystem::path& path);

// What a refused call means: disconnected when the device is gone, else device. "VIDIOC_S_FMT: in use by another
// program"
Fault device_fault(int error, std::string_view call);

}  // namespace kasumi
