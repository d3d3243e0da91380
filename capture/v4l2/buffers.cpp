#include "capture/v4l2/buffers.hpp"

#include <fcntl.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>

namespace kasumi {

namespace {

constexpr std::size_t kMinBuffers = 2;   // the minimum for streaming
constexpr std::size_t kMaxBuffers = 32;  // VIDEO_MAX_FRAME
constexpr std::size_t kDriverKeeps = 2;  // one being filled, one queued next

// v4l2_buffer with room for planes, for both single- and multi-planar devices.
struct Exchange {
  v4l2_buffer buffer{};
  std::array<v4l2_plane, VIDEO_MAX_PLANES> planes{};

  Exchange(const V4l2Layout& layout, std::uint32_t index) : multiplanar(layout.multiplanar()) {
    buffer.index = index;
    buffer.type = layout.buffer_type;
    buffer.memory = V4L2_MEMORY_MMAP;
    if (!multiplanar) return;
    buffer.m.planes = planes.data();
    buffer.length = static_cast<std::uint32_t>(layout.planes.size());
  }
  Exchange(const Exchange&) = delete;  // the buffer points to its own planes

  std::size_t plane_count() const { return multiplanar ? buffer.length : 1; }
  std::uint32_t length(std::size_t i) const { return multiplanar ? planes[i].length : buffer.length; }
  std::uint32_t map_offset(std::size_t i) const { return multiplanar ? planes[i].m.mem_offset : buffer.m.offset; }
  std::uint32_t bytes_used(std::size_t i) const { return multiplanar ? planes[i].bytesused : buffer.bytesused; }
  std::uint32_t data_offset(std::size_t i) const { return multiplanar ? planes[i].data_offset : 0; }

  const bool multiplanar;
};

}  // namespace

V4l2Buffers::V4l2Buffers(std::unique_ptr<VideoDevice> device, const V4l2Layout& layout)
    : device_(std::move(device)), layout_(layout) {}

V4l2Buffers::~V4l2Buffers() {
  stop();
  for (const auto& buffer : buffers_) unmap(buffer.planes);
  free_all();
}

Result<std::shared_ptr<V4l2Buffers>> V4l2Buffers::start(std::unique_ptr<VideoDevice> device, const V4l2Layout& layout,
                                                        int count) {
  const std::shared_ptr<V4l2Buffers> buffers(new V4l2Buffers(std::move(device), layout));
  if (auto allocated = buffers->allocate(count); !allocated) return fail(allocated.error());
  for (std::uint32_t index = 0; index < buffers->buffers_.size(); ++index) {
    if (auto mapped = buffers->map(index); !mapped) return fail(mapped.error());
    if (auto queued = buffers->queue(index); !queued) return fail(queued.error());
  }
  int type = static_cast<int>(layout.buffer_type);
  if (const int error = buffers->device_->control(VIDIOC_STREAMON, &type); error != 0)
    return fail(device_fault(error, "VIDIOC_STREAMON"));
  buffers->streaming_ = true;
  return buffers;
}

Result<> V4l2Buffers::allocate(int count) {
  v4l2_requestbuffers request{};
  request.count = static_cast<std::uint32_t>(count);
  request.type = layout_.buffer_type;
  request.memory = V4L2_MEMORY_MMAP;
  if (const int error = device_->control(VIDIOC_REQBUFS, &request); error != 0)
    return fail(device_fault(error, "VIDIOC_REQBUFS"));
  allocated_ = true;
  if (request.count < kMinBuffers || request.count > kMaxBuffers)
    return fail(FaultKind::device, "VIDIOC_REQBUFS: {} buffers: expected {} to {}", request.count, kMinBuffers,
                kMaxBuffers);
  buffers_.resize(request.count);
  return {};
}

Result<> V4l2Buffers::map(std::uint32_t index) {
  Exchange answer(layout_, index);
  if (const int error = device_->control(VIDIOC_QUERYBUF, &answer.buffer); error != 0)
    return fail(device_fault(error, "VIDIOC_QUERYBUF"));
  if (answer.plane_count() != layout_.planes.size())
    return fail(FaultKind::device, "VIDIOC_QUERYBUF: {} memory planes: expected {}", answer.plane_count(),
                layout_.planes.size());
  auto& buffer = buffers_[index];
  for (std::size_t i = 0; i < layout_.planes.size(); ++i) {
    const auto length = answer.length(i);
    if (length < layout_.planes[i].size || length > kLargestPayload)
      return fail(FaultKind::device, "VIDIOC_QUERYBUF: buffer {} has {} bytes: expected {} to {}", index, length,
                  layout_.planes[i].size, kLargestPayload);
    int error = 0;
    const auto memory = device_->map(length, answer.map_offset(i), error);
    if (error != 0) return fail(device_fault(error, fmt::format("mmap of {} bytes", length)));
    buffer.planes.push_back({memory, {}, new_buffer_number()});

    v4l2_exportbuffer request{};
    request.type = layout_.buffer_type;
    request.index = index;
    request.plane = static_cast<std::uint32_t>(i);
    request.flags = O_RDONLY | O_CLOEXEC;
    if (device_->control(VIDIOC_EXPBUF, &request) == 0) buffer.planes.back().exported = UniqueFd(request.fd);
  }
  return {};
}

Result<> V4l2Buffers::queue(std::uint32_t index) {
  Exchange exchange(layout_, index);
  if (const int error = device_->control(VIDIOC_QBUF, &exchange.buffer); error != 0)
    return fail(device_fault(error, "VIDIOC_QBUF"));
  buffers_[index].holder = Holder::driver;
  return {};
}

Result<> V4l2Buffers::queue_released() {
  std::vector<std::uint32_t> released;
  {
    const std::lock_guard lock(mutex_);
    if (!streaming_) return fail(FaultKind::device, "the stream has been stopped");
    released.swap(released_);
  }
  for (const auto index : released) buffers_[index].holder = Holder::source;
  for (const auto index : released)
    if (auto queued = queue(index); !queued) return queued;
  return {};
}

Result<std::optional<V4l2Filled>> V4l2Buffers::take() {
  if (auto queued = queue_released(); !queued) return fail(queued.error());
  Exchange answer(layout_, 0);
  if (const int error = device_->control(VIDIOC_DQBUF, &answer.buffer); error == EAGAIN)
    return std::optional<V4l2Filled>{};
  else if (error == EPIPE)
    return fail(FaultKind::device, "VIDIOC_DQBUF: the driver has ended the stream");
  else if (error != 0)
    return fail(device_fault(error, "VIDIOC_DQBUF"));

  const auto index = answer.buffer.index;
  if (index >= buffers_.size() || (buffers_[index].holder != Holder::driver && !layout_.shared))
    return fail(FaultKind::device, "VIDIOC_DQBUF: buffer {}: expected a queued buffer", index);
  auto& buffer = buffers_[index];
  buffer.holder = Holder::source;
  V4l2Filled filled;
  filled.index = index;
  filled.flags = answer.buffer.flags;
  filled.sequence = answer.buffer.sequence;
  filled.seconds = answer.buffer.timestamp.tv_sec;
  filled.microseconds = answer.buffer.timestamp.tv_usec;
  filled.impossible = answer.plane_count() != buffer.planes.size();
  for (std::size_t i = 0; i < buffer.planes.size(); ++i) {
    const auto memory = buffer.planes[i].memory;
    const std::size_t end = filled.impossible ? 0 : answer.bytes_used(i), begin = answer.data_offset(i);
    filled.impossible = filled.impossible || end > memory.size();
    const auto within = std::min(end, memory.size());
    const auto offset = std::min(begin, within);
    filled.planes.push_back({memory.subspan(offset, within - offset), static_cast<std::uint32_t>(offset)});
  }
  return filled;
}

Result<> V4l2Buffers::give_back(const V4l2Filled& filled) {
  return queue(filled.index);
}

bool V4l2Buffers::any_lent() const {
  return std::any_of(buffers_.begin(), buffers_.end(),
                     [](const Buffer& buffer) { return buffer.holder == Holder::reader; });
}

bool V4l2Buffers::can_lend() const {
  const auto with_driver = std::count_if(buffers_.begin(), buffers_.end(),
                                         [](const Buffer& buffer) { return buffer.holder == Holder::driver; });
  return !layout_.shared && static_cast<std::size_t>(with_driver) >= kDriverKeeps;
}

Payload V4l2Buffers::lend(const V4l2Filled& filled) {
  auto& buffer = buffers_[filled.index];
  buffer.holder = Holder::reader;
  const auto& first = buffer.planes.front();
  const auto bytes = filled.planes.front().bytes;
  Payload payload;
  payload.bytes = bytes;
  if (first.exported) payload.dma_buf = DmaBuf{first.exported.value(), filled.planes.front().offset, first.number};
  payload.holder = std::shared_ptr<const void>(
      bytes.data(), [self = shared_from_this(), index = filled.index](const void*) { self->release(index); });
  return payload;
}

void V4l2Buffers::release(std::uint32_t index) {
  {
    const std::lock_guard lock(mutex_);
    released_.push_back(index);
    if (streaming_) return;
  }
  unmap(std::exchange(buffers_[index].planes, {}));
}

void V4l2Buffers::stop() {
  bool was_streaming = false;
  {
    const std::lock_guard lock(mutex_);
    was_streaming = std::exchange(streaming_, false);
    // Released from now on, a buffer is its reader's to unmap.
    for (const auto index : std::exchange(released_, {})) buffers_[index].holder = Holder::source;
  }
  if (was_streaming) {
    int type = static_cast<int>(layout_.buffer_type);
    device_->control(VIDIOC_STREAMOFF, &type);  // fails on an unplugged device, but its memory is freed anyway
  }
  for (auto& buffer : buffers_)
    if (buffer.holder != Holder::reader) unmap(std::exchange(buffer.planes, {}));
  // Since 4.20 the kernel frees buffers that are still mapped, so the camera can be reopened at once.
  free_all();
}

void V4l2Buffers::unmap(const std::vector<Mapped>& planes) {
  for (const auto& plane : planes) device_->unmap(plane.memory);
}

void V4l2Buffers::free_all() {
  if (!allocated_) return;
  v4l2_requestbuffers request{};
  request.type = layout_.buffer_type;
  request.memory = V4L2_MEMORY_MMAP;
  const int error = device_->control(VIDIOC_REQBUFS, &request);
  allocated_ = error == EBUSY;
}

}  // namespace kasumi
