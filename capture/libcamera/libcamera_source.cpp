#include "capture/libcamera/libcamera_source.hpp"

#include <linux/dma-buf.h>
#include <sys/ioctl.h>
#include <sys/mman.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstring>
#include <map>
#include <mutex>

#include "base/unique_fd.hpp"
#include "capture/driver_time.hpp"
#include "capture/libcamera/last_task.hpp"
#include "capture/libcamera/setup.hpp"

namespace kasumi {

namespace {

// Frames after which the camera's automatic white balance has settled.
constexpr std::uint64_t kSettled = 30;
// With fewer buffers the camera drops frames, so frames are copied instead of lent.
constexpr int kMinQueued = 2;

struct OnlyManager {
  std::mutex mutex;
  std::shared_ptr<libcamera::CameraManager> started;  // null: not yet
};
OnlyManager& only_manager() {
  static OnlyManager only;
  return only;
}

// libcamera allows one manager per process and does not restart reliably, so it lives as long as the process. It
// follows hotplugging by itself.
Result<std::shared_ptr<libcamera::CameraManager>> camera_manager() {
  auto& only = only_manager();
  const std::lock_guard lock(only.mutex);
  if (only.started) return only.started;
  auto started = std::make_shared<libcamera::CameraManager>();
  if (const int answer = started->start(); answer != 0)
    return fail(FaultKind::unsupported, "libcamera does not start: {}", std::strerror(-answer));
  only.started = std::move(started);
  return only.started;
}

// A frame buffer mapped into memory: each of its dma-bufs once, from its first byte.
class MappedBuffer {
 public:
  static Result<MappedBuffer> map(const libcamera::FrameBuffer& buffer) {
    MappedBuffer mapped;
    std::map<int, std::size_t> lengths;
    for (const auto& plane : buffer.planes()) {
      const std::size_t offset = plane.offset == libcamera::FrameBuffer::Plane::kInvalidOffset ? 0 : plane.offset;
      auto& length = lengths[plane.fd.get()];
      length = std::max(length, offset + plane.length);
    }
    std::map<int, const std::uint8_t*> starts;
    for (const auto& [fd, length] : lengths) {
      void* memory = ::mmap(nullptr, length, PROT_READ, MAP_SHARED, fd, 0);
      if (memory == MAP_FAILED) return fail(FaultKind::device, "mmap of {} bytes: {}", length, std::strerror(errno));
      mapped.memories_.push_back({memory, length});
      starts[fd] = static_cast<const std::uint8_t*>(memory);
    }
    for (const auto& plane : buffer.planes()) {
      const std::size_t offset = plane.offset == libcamera::FrameBuffer::Plane::kInvalidOffset ? 0 : plane.offset;
      mapped.planes_.emplace_back(starts[plane.fd.get()] + offset, plane.length);
    }
    if (!buffer.planes().empty()) {
      mapped.fd_ = UniqueFd(::dup(buffer.planes().front().fd.get()));
      const auto offset = buffer.planes().front().offset;
      mapped.first_offset_ = offset == libcamera::FrameBuffer::Plane::kInvalidOffset ? 0 : offset;
    }
    return mapped;
  }
  MappedBuffer(MappedBuffer&&) noexcept = default;
  MappedBuffer& operator=(MappedBuffer&&) = delete;
  ~MappedBuffer() {
    for (const auto& [memory, length] : memories_) ::munmap(memory, length);
  }

  const std::vector<std::span<const std::uint8_t>>& planes() const { return planes_; }
  int fd() const { return fd_.value(); }
  std::uint32_t first_offset() const { return first_offset_; }

 private:
  MappedBuffer() = default;
  std::vector<std::pair<void*, std::size_t>> memories_;
  std::vector<std::span<const std::uint8_t>> planes_;
  UniqueFd fd_;
  std::uint32_t first_offset_ = 0;
};

struct Memory {
  MappedBuffer mapped;
  std::uint64_t number = 0;
};

// CPU caches must be synchronised with what the camera wrote. Buffers that do not need it refuse the ioctl, which is
// harmless.
class CpuRead {
 public:
  explicit CpuRead(std::shared_ptr<const Memory> memory) : memory_(std::move(memory)) { sync(DMA_BUF_SYNC_START); }
  CpuRead(const CpuRead&) = delete;
  CpuRead& operator=(const CpuRead&) = delete;
  ~CpuRead() { sync(DMA_BUF_SYNC_END); }

 private:
  void sync(std::uint64_t edge) {
    dma_buf_sync request{edge | DMA_BUF_SYNC_READ};
    ::ioctl(memory_->mapped.fd(), DMA_BUF_IOCTL_SYNC, &request);
  }
  std::shared_ptr<const Memory> memory_;
};

// A streaming camera. Lent frames share it, to return their buffer or to find that the camera has stopped.
class Session : public std::enable_shared_from_this<Session> {
 public:
  static Result<std::shared_ptr<Session>> start(std::shared_ptr<libcamera::Camera> camera,
                                                const LibcameraOptions& options) {
    auto session = std::shared_ptr<Session>(new Session(std::move(camera), options.request));
    if (auto begun = session->begin(); !begun) {
      session->stop();
      return fail(begun.error());
    }
    return session;
  }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  ~Session() = default;

  // Stops and releases the camera, once; frames still lent keep only their memory.
  void stop() {
    if (!acquired_) return;
    {
      const std::lock_guard lock(mutex_);
      streaming_ = false;
    }
    camera_->stop();  // cancels queued requests, which calls request_completed; does nothing once it is unplugged
    if (queued() == 0) return let_go();
    // Unplugged, which libcamera 0.0.3 reports for USB cameras only; stopping any other camera that is gone aborts the
    // program by an assertion in PipelineHandler::stop(). The camera's thread may still use the requests that were not
    // given back, until the camera itself is gone: so that thread frees both, between two of its tasks.
    run_after_queued_tasks(*camera_, [session = shared_from_this()] { session->let_go(); });
  }

  // BLOCKS until a request is finished or the deadline passes. Older ones go back to the camera.
  Result<libcamera::Request*> newest(Instant deadline, const Clock& clock) {
    std::unique_lock lock(mutex_);
    while (!returned_.empty() || (finished_.empty() && !gone_)) {
      if (!returned_.empty()) {
        const auto returned = std::exchange(returned_, {});
        lock.unlock();
        for (auto* request : returned) requeue(request);
        lock.lock();
        continue;
      }
      const auto left = deadline - clock.now();
      if (left <= Duration::zero()) return fail(FaultKind::timeout, "{}: no frame by the deadline", camera_->id());
      arrived_.wait_for(lock, left);
    }
    if (gone_) return fail(FaultKind::disconnected, "{}: unplugged", camera_->id());
    auto finished = std::exchange(finished_, {});
    lock.unlock();
    for (std::size_t i = 0; i + 1 < finished.size(); ++i) requeue(finished[i]);
    return finished.back();
  }

  // By the source's thread; no lock is held over a call into the camera.
  void requeue(libcamera::Request* request) {
    request->reuse(libcamera::Request::ReuseBuffers);
    if (wanted_) request->controls().merge(*std::exchange(wanted_, std::nullopt));
    count_queued(1);
    if (camera_->queueRequest(request) != 0) count_queued(-1);
  }

  // By a reader, in any thread: the source's thread queues it, since the camera may hang.
  void give_back(libcamera::Request* request) {
    const std::lock_guard lock(mutex_);
    if (!streaming_) return;
    returned_.push_back(request);
    arrived_.notify_one();
  }

  // With the next request that goes to the camera.
  void set(libcamera::ControlList controls) { wanted_ = std::move(controls); }

  int queued() {
    const std::lock_guard lock(mutex_);
    return queued_;
  }
  std::shared_ptr<const Memory> memory_of(const libcamera::FrameBuffer* buffer) const { return memories_.at(buffer); }
  const libcamera::StreamConfiguration& stream() const { return configuration_->at(0); }
  libcamera::Stream* stream_key() const { return configuration_->at(0).stream(); }
  const libcamera::Camera& camera() const { return *camera_; }
  const std::vector<std::string>& notes() const { return notes_; }

 private:
  // The requests before the buffers they name, and both before the camera. In the camera's thread, the last reference
  // to the camera deletes it at once.
  void let_go() {
    camera_->requestCompleted.disconnect(this);
    camera_->disconnected.disconnect(this);
    requests_.clear();
    allocator_.reset();
    configuration_.reset();
    camera_->release();
    camera_.reset();
    acquired_ = false;
  }

  Session(std::shared_ptr<libcamera::Camera> camera, const CameraRequest& request)
      : camera_(std::move(camera)), request_(request) {}

  Result<> begin() {
    const auto refuse = [&](std::string_view what, int answer) {
      const auto kind = answer == -ENODEV ? FaultKind::disconnected : FaultKind::device;
      return fail(kind, "{}: {}: {}", camera_->id(), what, std::strerror(-answer));
    };
    if (const int answer = camera_->acquire(); answer != 0)
      return refuse(answer == -EBUSY ? "in use by another program" : "cannot be acquired", answer);
    acquired_ = true;
    auto chosen = choose_configuration(*camera_, request_);
    if (!chosen) return fail(chosen.error());
    configuration_ = std::move(*chosen);
    if (const int answer = camera_->configure(configuration_.get()); answer != 0) return refuse("configure", answer);

    allocator_ = std::make_unique<libcamera::FrameBufferAllocator>(camera_);
    if (const int answer = allocator_->allocate(stream_key()); answer < 0) return refuse("allocate buffers", answer);
    static std::atomic<std::uint64_t> numbers{std::uint64_t{1} << 32U};  // distinct from those of other camera types
    for (const auto& buffer : allocator_->buffers(stream_key())) {
      auto mapped = MappedBuffer::map(*buffer);
      if (!mapped) return fail(mapped.error());
      memories_[buffer.get()] = std::make_shared<const Memory>(Memory{std::move(*mapped), numbers++});
      auto request = camera_->createRequest();
      if (!request) return fail(FaultKind::device, "{}: cannot create a request", camera_->id());
      if (const int answer = request->addBuffer(stream_key(), buffer.get()); answer != 0)
        return refuse("add a buffer", answer);
      requests_.push_back(std::move(request));
    }

    camera_->requestCompleted.connect(this, &Session::request_completed);
    camera_->disconnected.connect(this, &Session::camera_gone);
    auto controls = controls_for(*camera_, request_, notes_);
    streaming_ = true;
    if (const int answer = camera_->start(&controls); answer != 0) return refuse("start", answer);
    for (const auto& request : requests_) {
      count_queued(1);
      if (const int answer = camera_->queueRequest(request.get()); answer != 0) return refuse("queue", answer);
    }
    return {};
  }

  void count_queued(int change) {
    const std::lock_guard lock(mutex_);
    queued_ += change;
  }

  // Runs in libcamera's thread.
  void request_completed(libcamera::Request* request) {
    const std::lock_guard lock(mutex_);
    --queued_;
    if (request->status() == libcamera::Request::RequestCancelled || !streaming_) return;
    finished_.push_back(request);
    arrived_.notify_one();
  }
  void camera_gone() {
    const std::lock_guard lock(mutex_);
    gone_ = true;
    arrived_.notify_one();
  }

  std::shared_ptr<libcamera::Camera> camera_;
  CameraRequest request_;
  bool acquired_ = false;
  std::unique_ptr<libcamera::CameraConfiguration> configuration_;
  std::unique_ptr<libcamera::FrameBufferAllocator> allocator_;
  std::map<const libcamera::FrameBuffer*, std::shared_ptr<const Memory>> memories_;
  std::vector<std::unique_ptr<libcamera::Request>> requests_;
  std::vector<std::string> notes_;
  std::optional<libcamera::ControlList> wanted_;

  std::mutex mutex_;  // guards everything below
  std::condition_variable arrived_;
  std::vector<libcamera::Request*> finished_;  // oldest first
  std::vector<libcamera::Request*> returned_;  // by readers, not yet queued again
  int queued_ = 0;
  bool streaming_ = false;
  bool gone_ = false;
};

class LibcameraSource final : public CameraSource {
 public:
  LibcameraSource(std::shared_ptr<Session> session, const LibcameraOptions& options, Clock& clock)
      : session_(std::move(session)), options_(options), clock_(clock) {
    const auto& stream = session_->stream();
    mode_.format = *four_cc_of(stream.pixelFormat);
    mode_.width = static_cast<int>(stream.size.width);
    mode_.height = static_cast<int>(stream.size.height);
    mode_.stride = mode_.format == kMjpg ? 0 : stream.stride;
    mode_.driver = "libcamera " + libcamera::CameraManager::version();
    if (const auto model = session_->camera().properties().get(libcamera::properties::Model)) mode_.card = *model;
    mode_.place = session_->camera().id();
    mode_.notes = session_->notes();
  }
  ~LibcameraSource() override { session_->stop(); }

  std::string description() const override {
    return fmt::format("{} ({} {}x{})", options_.camera, mode_.format.text(), mode_.width, mode_.height);
  }
  const CameraMode& mode() const override { return mode_; }
  std::uint64_t frames_copied() const override { return copied_; }

  Result<Frame> next(Instant deadline) override {
    auto request = session_->newest(deadline, clock_);
    if (!request) return fail(request.error());
    const auto* buffer = (*request)->findBuffer(session_->stream_key());
    if (buffer == nullptr) {
      session_->requeue(*request);
      return fail(FaultKind::device, "{}: a completed request lacks its buffer", options_.camera);
    }
    Frame frame;
    frame.metadata = read_metadata(**request, *buffer);
    if (++seen_ == kSettled && options_.request.lock_white_balance)
      session_->set(white_balance_lock(session_->camera(), (*request)->metadata()));
    if (!lend_or_copy(frame, *request, *buffer)) session_->requeue(*request);
    return frame;
  }

 private:
  FrameMetadata read_metadata(const libcamera::Request& request, const libcamera::FrameBuffer& buffer) {
    const auto& completed = buffer.metadata();
    FrameMetadata metadata;
    metadata.captured_at = bounded_driver_time(std::uint64_t{completed.timestamp}, clock_.now());
    metadata.utc = utc_of_capture(metadata.captured_at, clock_);
    metadata.sequence = completed.sequence;
    metadata.format = mode_.format;
    metadata.width = mode_.width;
    metadata.height = mode_.height;
    metadata.stride = mode_.stride;
    const auto& answers = const_cast<libcamera::Request&>(request).metadata();  // the getter is not const
    if (const auto exposure = answers.get(libcamera::controls::ExposureTime)) metadata.exposure_s = *exposure * 1e-6;
    if (const auto gain = answers.get(libcamera::controls::AnalogueGain))
      metadata.gain = double{*gain} * double{answers.get(libcamera::controls::DigitalGain).value_or(1.0F)};
    mode_.exposure_s = metadata.exposure_s;
    mode_.gain = metadata.gain;
    if (const auto temperature = answers.get(libcamera::controls::ColourTemperature))
      mode_.white_balance_k = *temperature;
    if (const auto duration = answers.get(libcamera::controls::FrameDuration); duration && *duration > 0)
      mode_.frames_per_second = 1e6 / static_cast<double>(*duration);
    metadata.status =
        completed.status == libcamera::FrameMetadata::FrameSuccess ? FrameStatus::good : FrameStatus::flagged;
    return metadata;
  }

  // Lends the buffer if its planes have Kasumi's layout and the camera can spare it, else copies. True when lent.
  bool lend_or_copy(Frame& frame, libcamera::Request* request, const libcamera::FrameBuffer& buffer) {
    const auto memory = session_->memory_of(&buffer);
    const auto& planes = memory->mapped.planes();
    const auto used = buffer.metadata().planes();
    const bool flagged = frame.metadata.status == FrameStatus::flagged;
    bool contiguous = true;
    std::size_t bytes = 0;
    for (std::size_t i = 0; i < planes.size(); ++i) {
      contiguous = contiguous && planes[i].data() == planes.front().data() + bytes;
      const std::size_t bytes_used = i < used.size() ? used[i].bytesused : 0;
      bytes += std::min<std::size_t>(bytes_used == 0 && i > 0 ? planes[i].size() : bytes_used, planes[i].size());
    }
    frame.metadata.bytes_used = static_cast<std::uint32_t>(std::min<std::size_t>(bytes, kLargestPayload));
    frame.metadata.status = judge(frame.metadata, bytes, flagged);
    if (frame.metadata.status != FrameStatus::good) return false;

    const bool spare = options_.request.lend_buffers && session_->queued() >= kMinQueued;
    if (contiguous && spare) {
      frame.payload.bytes = {planes.front().data(), bytes};
      frame.payload.dma_buf = DmaBuf{memory->mapped.fd(), memory->mapped.first_offset(), memory->number};
      // The memory outlives the session; the buffer goes back to the camera if it is still streaming.
      auto read = std::make_unique<CpuRead>(memory);
      frame.payload.holder = std::shared_ptr<const void>(
          read.release(), [request, session = std::weak_ptr(session_)](const void* reading) {
            delete static_cast<const CpuRead*>(reading);
            if (const auto alive = session.lock()) alive->give_back(request);
          });
      return true;
    }
    const CpuRead reading(memory);
    std::vector<std::uint8_t> copy;
    copy.reserve(bytes);
    for (std::size_t i = 0; i < planes.size(); ++i) {
      const std::size_t bytes_used = i < used.size() && used[i].bytesused > 0 ? used[i].bytesused : planes[i].size();
      const auto part = planes[i].first(std::min(bytes_used, planes[i].size()));
      copy.insert(copy.end(), part.begin(), part.end());
    }
    frame.payload = payload_of(std::move(copy));
    ++copied_;
    return false;
  }

  std::shared_ptr<Session> session_;
  LibcameraOptions options_;
  Clock& clock_;
  CameraMode mode_;
  std::uint64_t copied_ = 0;
  std::uint64_t seen_ = 0;
};

}  // namespace

Result<std::vector<LibcameraListing>> list_libcamera_cameras() {
  auto manager = camera_manager();
  if (!manager) return fail(manager.error());
  std::vector<LibcameraListing> list;
  for (const auto& camera : (*manager)->cameras())
    list.push_back({camera->id(), camera->properties().get(libcamera::properties::Model).value_or("")});
  return list;
}

// Another thread may be starting the manager, which takes long: that is no reason to wait here.
bool is_libcamera_camera_present(const std::string& camera) {
  auto& only = only_manager();
  const std::unique_lock lock(only.mutex, std::try_to_lock);
  return lock.owns_lock() && only.started && only.started->get(camera) != nullptr;
}

Result<std::unique_ptr<CameraSource>> open_libcamera_source(const LibcameraOptions& options, Clock& clock) {
  auto manager = camera_manager();
  if (!manager) return fail(manager.error());
  auto camera = (*manager)->get(options.camera);
  if (!camera) {
    std::string there;
    for (const auto& other : (*manager)->cameras()) there += (there.empty() ? "" : ", ") + other->id();
    return fail(FaultKind::disconnected, "{}: no such camera; available: {}", options.camera,
                there.empty() ? "none" : there);
  }
  auto session = Session::start(std::move(camera), options);
  if (!session) return fail(session.error());
  return std::make_unique<LibcameraSource>(std::move(*session), options, clock);
}

}  // namespace kasumi
