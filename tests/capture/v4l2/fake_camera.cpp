#include "tests/capture/v4l2/fake_camera.hpp"

#include <linux/v4l2-controls.h>
#include <sys/mman.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "capture/v4l2/formats.hpp"

namespace kasumi {

class FakeVideoDevice final : public VideoDevice {
 public:
  explicit FakeVideoDevice(FakeCamera& camera) : camera_(camera) {}
  ~FakeVideoDevice() override { camera_.close(this); }
  int control(unsigned long request, void* argument) override { return camera_.control(this, request, argument); }
  VideoEvents wait(Duration longest) override { return camera_.wait(longest); }
  std::span<const std::uint8_t> map(std::size_t length, std::int64_t offset, int& error) override {
    return camera_.map(length, offset, error);
  }
  void unmap(std::span<const std::uint8_t> mapped) override { camera_.unmap(mapped); }

 private:
  FakeCamera& camera_;
};

namespace {

template <std::size_t N>
void put(std::uint8_t (&field)[N], std::string_view text) {
  std::memcpy(field, text.data(), std::min(N - 1, text.size()));
}

constexpr std::int64_t kMapStep = 1 << 24;  // buffer and plane by mmap offset

}  // namespace

FakeCamera::FakeCamera(std::vector<FakeMode> modes, Clock& clock)
    : modes_(std::move(modes)), clock_(clock), now_(modes_.front()) {}
FakeCamera::~FakeCamera() = default;

std::unique_ptr<VideoDevice> FakeCamera::open() {
  auto device = std::make_unique<FakeVideoDevice>(*this);
  const std::lock_guard lock(mutex_);
  devices_.insert(device.get());
  return device;
}

void FakeCamera::close(const VideoDevice* caller) {
  const std::lock_guard lock(mutex_);
  devices_.erase(caller);
  if (owner_ != caller) return;
  // As the kernel does when the last reference to the file is closed.
  buffers_.clear();
  done_.clear();
  streaming_ = failed_ = false;
  owner_ = nullptr;
}

void FakeCamera::refuse(unsigned long request, int error, int times) {
  const std::lock_guard lock(mutex_);
  refusals_[request] = {error, times};
}
void FakeCamera::tamper(std::function<void(FakeAnswer&)> change) {
  const std::lock_guard lock(mutex_);
  change_ = std::move(change);
}
void FakeCamera::lie(std::function<void(unsigned long, void*)> lie) {
  const std::lock_guard lock(mutex_);
  lie_ = std::move(lie);
}
void FakeCamera::stop_filling(bool stopped) {
  const std::lock_guard lock(mutex_);
  fill_due();
  stopped_ = stopped;
}
void FakeCamera::fail_queue() {
  const std::lock_guard lock(mutex_);
  failed_ = true;
}
void FakeCamera::announce_source_change() {
  const std::lock_guard lock(mutex_);
  event_ = subscribed_;
}
void FakeCamera::unplug() {
  const std::lock_guard lock(mutex_);
  plugged_in_ = false;
}
void FakeCamera::plug_in() {
  const std::lock_guard lock(mutex_);
  plugged_in_ = true;
}
bool FakeCamera::plugged_in() const {
  const std::lock_guard lock(mutex_);
  return plugged_in_;
}
int FakeCamera::opened() const {
  const std::lock_guard lock(mutex_);
  return static_cast<int>(devices_.size());
}
int FakeCamera::mapped() const {
  const std::lock_guard lock(mutex_);
  return static_cast<int>(mappings_.size());
}
bool FakeCamera::allocated() const {
  const std::lock_guard lock(mutex_);
  return !buffers_.empty();
}
bool FakeCamera::streaming() const {
  const std::lock_guard lock(mutex_);
  return streaming_;
}
int FakeCamera::with_driver() const {
  const std::lock_guard lock(mutex_);
  return static_cast<int>(
      std::count_if(buffers_.begin(), buffers_.end(), [](const auto& b) { return b.state != State::idle; }));
}
std::vector<unsigned long> FakeCamera::calls() const {
  const std::lock_guard lock(mutex_);
  return calls_;
}

const FakeMode* FakeCamera::mode_of(std::uint32_t code, std::uint32_t width, std::uint32_t height) const {
  for (const auto& mode : modes_)
    if (mode.code == code && mode.width == static_cast<int>(width) && mode.height == static_cast<int>(height))
      return &mode;
  return nullptr;
}

std::vector<std::uint32_t> FakeCamera::plane_strides() const {
  const auto* format = find_v4l2_format(now_.code);
  const auto layout = format ? layout_of(format->format) : std::nullopt;
  if (!layout) return {0};
  std::vector<std::uint32_t> strides;
  for (std::uint32_t plane = 0; plane < format->planes; ++plane)
    strides.push_back(
        static_cast<std::uint32_t>(plane_size(*layout, now_.width, now_.height, static_cast<int>(plane)).row_bytes) +
        now_.padding);
  return strides;
}

std::vector<std::uint32_t> FakeCamera::plane_sizes() const {
  const auto* format = find_v4l2_format(now_.code);
  const auto layout = format ? layout_of(format->format) : std::nullopt;
  const auto pixels = static_cast<std::uint32_t>(now_.width * now_.height);
  if (!layout) return {pixels * 2};
  const auto strides = plane_strides();
  std::vector<std::uint32_t> sizes;
  for (std::uint32_t plane = 0; plane < strides.size(); ++plane)
    sizes.push_back(strides[plane] * static_cast<std::uint32_t>(
                                         plane_size(*layout, now_.width, now_.height, static_cast<int>(plane)).rows));
  if (sizes.size() > 1) return sizes;
  for (int plane = 1; plane < plane_count(*layout); ++plane)
    sizes[0] += stride_of_plane(*layout, strides[0], plane) *
                static_cast<std::uint32_t>(plane_size(*layout, now_.width, now_.height, plane).rows);
  return sizes;
}

int FakeCamera::control(const VideoDevice* caller, unsigned long request, void* argument) {
  const std::lock_guard lock(mutex_);
  calls_.push_back(request);
  if (!plugged_in_) return ENODEV;
  if (const auto found = refusals_.find(request); found != refusals_.end() && found->second.second > 0) {
    --found->second.second;
    return found->second.first;
  }
  const int error = dispatch(caller, request, argument);
  if (error == 0 && lie_) lie_(request, argument);
  return error;
}

int FakeCamera::dispatch(const VideoDevice* caller, unsigned long request, void* argument) {
  switch (request) {
    case VIDIOC_QUERYCAP: {
      auto& capability = *static_cast<v4l2_capability*>(argument);
      put(capability.driver, driver);
      put(capability.card, "Fake Camera");
      put(capability.bus_info, "usb-0000:00:14.0-2");
      capability.device_caps =
          V4L2_CAP_STREAMING | (multiplanar ? V4L2_CAP_VIDEO_CAPTURE_MPLANE : V4L2_CAP_VIDEO_CAPTURE);
      capability.capabilities = capability.device_caps | V4L2_CAP_DEVICE_CAPS;
      return 0;
    }
    case VIDIOC_ENUM_FMT: return enumerate_format(*static_cast<v4l2_fmtdesc*>(argument));
    case VIDIOC_ENUM_FRAMESIZES: return enumerate_size(*static_cast<v4l2_frmsizeenum*>(argument));
    case VIDIOC_ENUM_FRAMEINTERVALS: return enumerate_interval(*static_cast<v4l2_frmivalenum*>(argument));
    case VIDIOC_S_FMT: return set_format(*static_cast<v4l2_format*>(argument));
    case VIDIOC_G_PARM:
    case VIDIOC_S_PARM: {
      auto& parameters = *static_cast<v4l2_streamparm*>(argument);
      if (parameters.type != type()) return EINVAL;
      if (now_.intervals.empty()) return ENOTTY;
      if (request == VIDIOC_S_PARM) {
        const auto wanted = parameters.parm.capture.timeperframe;
        const auto same = [&](const v4l2_fract& f) {
          return f.numerator == wanted.numerator && f.denominator == wanted.denominator;
        };
        const auto found = std::find_if(now_.intervals.begin(), now_.intervals.end(), same);
        per_frame_ = found == now_.intervals.end() ? now_.intervals.front() : *found;
      }
      parameters.parm.capture.capability = V4L2_CAP_TIMEPERFRAME;
      parameters.parm.capture.timeperframe = per_frame_;
      return 0;
    }
    case VIDIOC_REQBUFS: return request_buffers(caller, *static_cast<v4l2_requestbuffers*>(argument));
    case VIDIOC_QUERYBUF: return query_buffer(*static_cast<v4l2_buffer*>(argument));
    case VIDIOC_EXPBUF: return export_buffer(*static_cast<v4l2_exportbuffer*>(argument));
    case VIDIOC_QBUF: return queue(*static_cast<v4l2_buffer*>(argument));
    case VIDIOC_DQBUF: return dequeue(*static_cast<v4l2_buffer*>(argument));
    case VIDIOC_STREAMON: return start_stream(true);
    case VIDIOC_STREAMOFF: return start_stream(false);
    case VIDIOC_SUBSCRIBE_EVENT: subscribed_ = true; return 0;
    case VIDIOC_DQEVENT: {
      if (!std::exchange(event_, false)) return ENOENT;
      auto& event = *static_cast<v4l2_event*>(argument);
      event.type = V4L2_EVENT_SOURCE_CHANGE;
      event.u.src_change.changes = V4L2_EVENT_SRC_CH_RESOLUTION;
      return 0;
    }
    case VIDIOC_QUERYCTRL:
    case VIDIOC_QUERYMENU:
    case VIDIOC_G_CTRL:
    case VIDIOC_S_CTRL: return control_value(request, argument);
    default: return ENOTTY;
  }
}

int FakeCamera::control_value(unsigned long request, void* argument) {
  const auto id = *static_cast<std::uint32_t*>(argument);  // the first field of each of these structures
  const auto found = controls.find(id);
  if (found == controls.end()) return EINVAL;
  auto& control = found->second;
  if (request == VIDIOC_QUERYCTRL) {
    auto& query = *static_cast<v4l2_queryctrl*>(argument);
    query.minimum = control.least;
    query.maximum = control.most;
    query.step = control.step;
  } else if (request == VIDIOC_QUERYMENU) {
    const auto& query = *static_cast<v4l2_querymenu*>(argument);
    return control.items.contains(static_cast<std::int32_t>(query.index)) ? 0 : EINVAL;
  } else if (request == VIDIOC_G_CTRL) {
    static_cast<v4l2_control*>(argument)->value = control.value;
  } else {
    const auto value = static_cast<v4l2_control*>(argument)->value;
    if (!control.items.empty() && !control.items.contains(value)) return EINVAL;
    if (control.items.empty() && (value < control.least || value > control.most)) return ERANGE;
    control.value = value;
  }
  return 0;
}

int FakeCamera::enumerate_format(v4l2_fmtdesc& entry) const {
  if (entry.type != type()) return EINVAL;
  std::vector<std::uint32_t> codes;
  for (const auto& mode : modes_)
    if (std::find(codes.begin(), codes.end(), mode.code) == codes.end()) codes.push_back(mode.code);
  if (entry.index >= codes.size()) return EINVAL;
  entry.pixelformat = codes[entry.index];
  return 0;
}

int FakeCamera::enumerate_size(v4l2_frmsizeenum& entry) const {
  if (!enumerates_sizes) return ENOTTY;
  std::uint32_t index = 0;
  for (const auto& mode : modes_) {
    if (mode.code != entry.pixel_format || index++ != entry.index) continue;
    entry.type = V4L2_FRMSIZE_TYPE_DISCRETE;
    entry.discrete = {static_cast<std::uint32_t>(mode.width), static_cast<std::uint32_t>(mode.height)};
    return 0;
  }
  return EINVAL;
}

int FakeCamera::enumerate_interval(v4l2_frmivalenum& entry) const {
  const auto* mode = mode_of(entry.pixel_format, entry.width, entry.height);
  if (!mode || entry.index >= mode->intervals.size()) return EINVAL;
  entry.type = V4L2_FRMIVAL_TYPE_DISCRETE;
  entry.discrete = mode->intervals[entry.index];
  return 0;
}

int FakeCamera::set_format(v4l2_format& format) {
  if (format.type != type()) return EINVAL;
  if (!buffers_.empty()) return EBUSY;
  const auto code = multiplanar ? format.fmt.pix_mp.pixelformat : format.fmt.pix.pixelformat;
  const auto width = multiplanar ? format.fmt.pix_mp.width : format.fmt.pix.width;
  const auto height = multiplanar ? format.fmt.pix_mp.height : format.fmt.pix.height;
  const auto* mode = mode_of(code, width, height);
  now_ = mode ? *mode : modes_.front();  // a driver substitutes what it supports
  per_frame_ = now_.intervals.empty() ? v4l2_fract{0, 0} : now_.intervals.front();
  const auto strides = plane_strides(), sizes = plane_sizes();
  if (multiplanar) {
    auto& pix = format.fmt.pix_mp;
    pix.width = static_cast<std::uint32_t>(now_.width);
    pix.height = static_cast<std::uint32_t>(now_.height);
    pix.pixelformat = now_.code;
    pix.num_planes = static_cast<std::uint8_t>(sizes.size());
    for (std::size_t i = 0; i < sizes.size(); ++i) {
      pix.plane_fmt[i].bytesperline = strides[i];
      pix.plane_fmt[i].sizeimage = sizes[i];
    }
    pix.colorspace = colour_space;
    pix.ycbcr_enc = static_cast<std::uint8_t>(ycbcr_encoding);
    pix.quantization = static_cast<std::uint8_t>(quantization);
  } else {
    auto& pix = format.fmt.pix;
    pix.width = static_cast<std::uint32_t>(now_.width);
    pix.height = static_cast<std::uint32_t>(now_.height);
    pix.pixelformat = now_.code;
    pix.bytesperline = strides[0];
    pix.sizeimage = sizes[0];
    pix.colorspace = colour_space;
    pix.ycbcr_enc = ycbcr_encoding;
    pix.quantization = quantization;
  }
  return 0;
}

int FakeCamera::request_buffers(const VideoDevice* caller, v4l2_requestbuffers& request) {
  if (request.type != type() || request.memory != V4L2_MEMORY_MMAP) return EINVAL;
  if (owner_ && owner_ != caller) return EBUSY;
  if (!buffers_.empty() && !mappings_.empty() && !keeps_orphans) return EBUSY;
  start_stream(false);
  buffers_.clear();
  owner_ = nullptr;
  request.count = std::min(request.count, most_buffers);
  if (request.count == 0) return 0;
  owner_ = caller;
  buffers_.resize(request.count);
  for (auto& buffer : buffers_)
    for (const auto size : plane_sizes())
      buffer.planes.push_back({size, std::make_shared<std::vector<std::uint8_t>>(size)});
  return 0;
}

int FakeCamera::query_buffer(v4l2_buffer& buffer) {
  if (buffer.type != type() || buffer.index >= buffers_.size()) return EINVAL;
  const auto& planes = buffers_[buffer.index].planes;
  if (!multiplanar) {
    buffer.length = planes[0].length;
    buffer.m.offset = static_cast<std::uint32_t>(buffer.index * kMapStep);
    return 0;
  }
  if (buffer.length < planes.size() || !buffer.m.planes) return EINVAL;
  buffer.length = static_cast<std::uint32_t>(planes.size());
  for (std::uint32_t i = 0; i < planes.size(); ++i) {
    buffer.m.planes[i].length = planes[i].length;
    buffer.m.planes[i].m.mem_offset = static_cast<std::uint32_t>(buffer.index * kMapStep) + (i << 12);
  }
  return 0;
}

int FakeCamera::export_buffer(v4l2_exportbuffer& request) {
  if (!exports) return ENOTTY;
  if (request.type != type() || request.index >= buffers_.size()) return EINVAL;
  request.fd = ::memfd_create("fake", MFD_CLOEXEC);
  return request.fd >= 0 ? 0 : errno;
}

int FakeCamera::queue(v4l2_buffer& buffer) {
  if (buffer.type != type() || buffer.index >= buffers_.size() || buffer.memory != V4L2_MEMORY_MMAP) return EINVAL;
  if (multiplanar && (!buffer.m.planes || buffer.length != buffers_[buffer.index].planes.size())) return EINVAL;
  fill_due();
  auto& queued = buffers_[buffer.index];
  if (shared) return 0;
  if (queued.state != State::idle) return EINVAL;
  queued.state = State::queued;
  return 0;
}

int FakeCamera::dequeue(v4l2_buffer& buffer) {
  if (buffer.type != type() || buffer.memory != V4L2_MEMORY_MMAP) return EINVAL;
  if (!streaming_) return EINVAL;
  if (failed_) return EIO;
  fill_due();
  if (done_.empty()) return EAGAIN;
  const auto index = done_.front();
  done_.erase(done_.begin());
  buffers_[index].state = State::idle;
  const auto& answer = buffers_[index].answer;
  auto* planes = buffer.m.planes;
  const auto room = buffer.length;
  buffer = answer.buffer;
  if (!multiplanar) {
    buffer.bytesused = answer.planes[0].bytesused;
    buffer.length = answer.planes[0].length;
    return 0;
  }
  buffer.m.planes = planes;
  for (std::uint32_t i = 0; i < std::min<std::size_t>(room, answer.planes.size()); ++i) planes[i] = answer.planes[i];
  if (buffer.length == 0) buffer.length = static_cast<std::uint32_t>(answer.planes.size());
  return 0;
}

int FakeCamera::start_stream(bool on) {
  if (on && buffers_.empty()) return EINVAL;
  streaming_ = on;
  failed_ = false;
  done_.clear();
  if (!on)
    for (auto& buffer : buffers_) buffer.state = State::idle;
  started_ = clock_.now();
  next_number_ = 0;
  return 0;
}

void FakeCamera::fill_due() {
  if (!streaming_ || failed_) return;
  while (started_ + interval * (next_number_ + 1) + latency <= clock_.now()) {
    const auto at = started_ + interval * (next_number_ + 1);
    const auto number = next_number_++;
    if (!stopped_) fill(number, at);
  }
}

// Fills the buffer queued longest; without one the frame is lost.
void FakeCamera::fill(std::uint32_t number, Instant at) {
  std::uint32_t index = 0;
  while (index < buffers_.size() && buffers_[index].state != State::queued) ++index;
  if (shared) {
    index = number % static_cast<std::uint32_t>(buffers_.size());
    std::erase(done_, index);
  }
  if (index == buffers_.size()) return;
  auto& buffer = buffers_[index];
  const auto bytes = content ? content(number) : std::vector<std::vector<std::uint8_t>>{};
  auto& answer = buffer.answer;
  answer = {};
  answer.number = number;
  answer.buffer.index = index;
  answer.buffer.type = type();
  answer.buffer.memory = V4L2_MEMORY_MMAP;
  answer.buffer.flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
  answer.buffer.sequence = number;
  const auto since = at.time_since_epoch();
  answer.buffer.timestamp.tv_sec = since / std::chrono::seconds(1);
  answer.buffer.timestamp.tv_usec = since % std::chrono::seconds(1) / std::chrono::microseconds(1);
  for (std::size_t i = 0; i < buffer.planes.size(); ++i) {
    auto& memory = *buffer.planes[i].bytes;
    v4l2_plane plane{};
    plane.length = plane.bytesused = buffer.planes[i].length;
    if (content) {
      plane.bytesused = static_cast<std::uint32_t>(std::min(bytes[i].size(), memory.size()));
      std::copy_n(bytes[i].begin(), plane.bytesused, memory.begin());
    } else {
      std::fill(memory.begin(), memory.end(), static_cast<std::uint8_t>(number));
    }
    answer.planes.push_back(plane);
  }
  if (change_) change_(answer);
  buffer.state = State::done;
  done_.push_back(index);
}

VideoEvents FakeCamera::wait(Duration longest) {
  const auto until = clock_.now() + longest;
  while (true) {
    Instant due;
    {
      const std::lock_guard lock(mutex_);
      if (!plugged_in_) return {.event = true, .error = true};
      if (!streaming_ || failed_) return {.error = true};
      fill_due();
      if (!done_.empty() || event_) return {.readable = !done_.empty(), .event = event_};
      due = std::min(until, started_ + interval * (next_number_ + 1) + latency);
    }
    if (clock_.now() >= until) return {};
    clock_.sleep_until(due);
    if (clock_.now() < due) return {};  // interrupted
  }
}

std::span<const std::uint8_t> FakeCamera::map(std::size_t length, std::int64_t offset, int& error) {
  const std::lock_guard lock(mutex_);
  const auto index = static_cast<std::size_t>(offset / kMapStep),
             plane = static_cast<std::size_t>(offset % kMapStep >> 12);
  error = !plugged_in_ ? ENODEV : 0;
  if (error == 0 && (index >= buffers_.size() || plane >= buffers_[index].planes.size() ||
                     length != buffers_[index].planes[plane].length))
    error = EINVAL;
  if (error != 0) return {};
  const auto& bytes = buffers_[index].planes[plane].bytes;
  mappings_[bytes->data()] = bytes;
  return *bytes;
}

void FakeCamera::unmap(std::span<const std::uint8_t> mapped) {
  const std::lock_guard lock(mutex_);
  mappings_.erase(mapped.data());
}

}  // namespace kasumi
