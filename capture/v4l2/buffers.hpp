// The buffers of one stream: requested, mapped, exported, exchanged with the driver, lent to readers and freed.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "base/unique_fd.hpp"
#include "capture/payload.hpp"
#include "capture/v4l2/negotiation.hpp"
#include "capture/v4l2/video_device.hpp"

namespace kasumi {

// What the driver put into a buffer, checked to lie within the mapping.
struct V4l2Filled {
  struct Plane {
    std::span<const std::uint8_t> bytes;  // never beyond the mapping
    std::uint32_t offset = 0;             // of the bytes within the buffer
  };
  std::uint32_t index = 0;
  std::uint32_t flags = 0;  // V4L2_BUF_FLAG_*
  std::uint32_t sequence = 0;
  std::int64_t seconds = 0, microseconds = 0;
  std::vector<Plane> planes;
  bool impossible = false;  // the driver claimed more bytes than there are, or another number of planes
};

// Frames may be released in any thread, which only notes it: a driver that hangs must not take the reader along.
// Everything else belongs to the source's thread, and every call that exchanges buffers is made there, without a lock.
// Shared by lent frames: memory is unmapped and the device closed with the last of them.
class V4l2Buffers : public std::enable_shared_from_this<V4l2Buffers> {
 public:
  // Requests, maps and queues all buffers and starts the stream. Undone if a step fails.
  static Result<std::shared_ptr<V4l2Buffers>> start(std::unique_ptr<VideoDevice> device, const V4l2Layout& layout,
                                                    int count);
  ~V4l2Buffers();

  VideoDevice& device() { return *device_; }
  // A filled buffer, or nothing; released ones go back to the driver first. Each one must be given back or lent. If the layout is shared it may be a buffer that
  // is already held, filled again.
  // Errors: device, disconnected; also when a released buffer could not be given back.
  Result<std::optional<V4l2Filled>> take();
  Result<> give_back(const V4l2Filled& filled);
  // Whether the driver keeps enough buffers not to drop frames.
  bool can_lend() const;
  // Whether readers hold any: then call take() again soon.
  bool any_lent() const;
  // The first plane's bytes in place; the driver gets the buffer back when the last holder releases it.
  Payload lend(const V4l2Filled& filled);
  // Ends the stream and frees all buffers that are not lent. take() fails from then on.
  void stop();

 private:
  struct Mapped {
    std::span<const std::uint8_t> memory;
    UniqueFd exported;
    std::uint64_t number = 0;
  };
  enum class Holder { driver, source, reader };
  struct Buffer {
    std::vector<Mapped> planes;
    Holder holder = Holder::source;
  };

  V4l2Buffers(std::unique_ptr<VideoDevice> device, const V4l2Layout& layout);
  Result<> allocate(int count);
  Result<> map(std::uint32_t index);
  Result<> queue(std::uint32_t index);
  Result<> queue_released();
  void release(std::uint32_t index);
  void unmap(const std::vector<Mapped>& planes);
  void free_all();

  std::unique_ptr<VideoDevice> device_;
  const V4l2Layout layout_;
  bool allocated_ = false;
  std::vector<Buffer> buffers_;  // while it streams, of the source's thread alone; then those lent, of their readers

  std::mutex mutex_;  // guards everything below; never held over a call into the driver
  bool streaming_ = false;
  std::vector<std::uint32_t> released_;  // by readers, not yet queued again
};

}  // namespace kasumi
