// The buffers of one stream: asked for, mapped, exported, exchanged with the driver, lent to readers, torn down.
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

// What the driver put into a buffer, found to lie within what was mapped.
struct V4l2Filled {
  struct Plane {
    std::span<const std::uint8_t> bytes;  // no more than are mapped
    std::uint32_t offset = 0;             // where they begin in the buffer
  };
  std::uint32_t index = 0;
  std::uint32_t flags = 0;  // V4L2_BUF_FLAG_*
  std::uint32_t sequence = 0;
  std::int64_t seconds = 0, microseconds = 0;
  std::vector<Plane> planes;
  bool impossible = false;  // it said more bytes than there are, or none of the planes agreed on
};

// Frames may be let go in any thread; all else belongs to the source's. Shared, because who holds a frame holds the
// memory: it is unmapped with the last of them, and the device closed.
class V4l2Buffers : public std::enable_shared_from_this<V4l2Buffers> {
 public:
  // Asks for buffers, maps and queues all of them and starts the stream. What was done is undone when a step fails.
  static Result<std::shared_ptr<V4l2Buffers>> start(std::unique_ptr<VideoDevice> device, const V4l2Layout& layout,
                                                    int count);
  ~V4l2Buffers();

  VideoDevice& device() { return *device_; }
  // A filled buffer, ours now, or nothing. Every one has to be given back or lent. Where the layout is shared it may be
  // one that is ours already, filled again.
  // Errors: device, disconnected; also when a reader's buffer could not be given back.
  Result<std::optional<V4l2Filled>> take();
  Result<> give_back(const V4l2Filled& filled);
  // As long as so many stay with the driver as it needs not to drop frames.
  bool can_lend() const;
  // The first plane's bytes where they lie; the driver gets the buffer when the last holder lets go.
  Payload lend(const V4l2Filled& filled);
  // Ends the stream and frees all that is not lent. Nothing can be taken any more.
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
  void release(std::uint32_t index);
  void unmap(Buffer& buffer);
  void free_all();

  std::unique_ptr<VideoDevice> device_;
  const V4l2Layout layout_;
  mutable std::mutex mutex_;  // of all below, and of the calls that exchange buffers
  std::vector<Buffer> buffers_;
  bool allocated_ = false;
  bool streaming_ = false;
  std::optional<Fault> release_fault_;
};

}  // namespace kasumi
