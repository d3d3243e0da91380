// The system calls that drive a V4L2 device: an interface that tests can replace.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "base/clock.hpp"
#include "base/result.hpp"

namespace kasumi {

struct VideoEvents {
  bool readable = false;  // a buffer can be dequeued
  bool event = false;     // an event can be dequeued
  bool error = false;     // the queue has failed, or the device is unplugged
};

class VideoDevice {
 public:
  virtual ~VideoDevice() = default;  // closes
  // ioctl(2): 0, or the errno. Never blocks for a frame. Thread-safe.
  virtual int control(unsigned long request, void* argument) = 0;
  // poll(2): BLOCKS until one of VideoEvents holds or `longest` has passed; may return early with none.
  virtual VideoEvents wait(Duration longest) = 0;
  // mmap(2), read-only: empty, with `error` set to errno, when refused.
  virtual std::span<const std::uint8_t> map(std::size_t length, std::int64_t offset, int& error) = 0;
  virtual void unmap(std::span<const std::uint8_t> mapped) = 0;
};

// Errors: disconnected (no such file), device (any other failure of open(2)), unsupported (not a character device).
Result<std::unique_ptr<VideoDevice>> open_video_device(const std::filesystem::path& path);

// "/dev/video0" and those that follow, by number, whatever they do.
std::vector<std::filesystem::path> video_nodes(const std::filesystem::path& devices);

// The fault for a failed call: disconnected when the device is unplugged, else device. "VIDIOC_S_FMT: in use by another
// program"
Fault device_fault(int error, std::string_view call);

}  // namespace kasumi
