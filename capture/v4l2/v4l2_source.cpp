#include "capture/v4l2/v4l2_source.hpp"

#include <linux/videodev2.h>

#include <algorithm>
#include <atomic>
#include <cerrno>

#include "capture/v4l2/buffers.hpp"
#include "capture/v4l2/controls.hpp"
#include "capture/v4l2/frames.hpp"
#include "capture/v4l2/negotiation.hpp"
#include "capture/v4l2/video_device.hpp"

namespace kasumi {

namespace {

// Frames and time after which the camera's automatic white balance has settled.
constexpr int kSettledFrames = 30;
constexpr Duration kSettled = std::chrono::seconds(2);
// Between polls of a device that reports being readable but delivers nothing.
constexpr Duration kRetryPause = std::chrono::milliseconds(1);
// Between looks for released buffers, which some drivers need before they fill another.
constexpr Duration kReleaseInterval = std::chrono::milliseconds(10);

class V4l2Source final : public CameraSource {
 public:
  V4l2Source(std::string description, const CameraRequest& request, CameraMode mode, V4l2Layout layout,
             std::shared_ptr<V4l2Buffers> buffers, bool watch_events, Clock& clock)
      : description_(std::move(description)),
        lend_buffers_(request.lend_buffers),
        lock_white_balance_(request.lock_white_balance && !request.white_balance_k),
        mode_(std::move(mode)),
        layout_(std::move(layout)),
        buffers_(std::move(buffers)),
        watch_events_(watch_events),
        clock_(clock),
        opened_at_(clock.now()) {}
  ~V4l2Source() override { buffers_->stop(); }

  std::string description() const override { return description_; }
  const CameraMode& mode() const override { return mode_; }
  std::uint64_t frames_copied() const override { return copied_; }

  Result<Frame> next(Instant deadline) override {
    if (fault_) return fail(*fault_);
    while (true) {
      auto frame = newest();
      if (!frame) return fail(remembered(frame.error()));
      if (*frame) return std::move(**frame);
      const auto now = clock_.now();
      if (now >= deadline) return fail(FaultKind::timeout, "{}: no frame", description_);
      if (auto fine = watch(deadline - now); !fine) return fail(remembered(fine.error()));
    }
  }

 private:
  // A failed stream must be closed: nothing the driver reports afterwards can be trusted.
  const Fault& remembered(Fault fault) {
    fault.message = fmt::format("{}: {}", description_, fault.message);
    return fault_.emplace(std::move(fault));
  }

  Result<> watch(Duration longest) {
    if (buffers_->any_lent()) longest = std::min(longest, kReleaseInterval);
    const auto events = buffers_->device().wait(longest);
    if (events.event && watch_events_)
      if (auto fine = read_event(); !fine) return fine;
    if (events.error && !events.readable) return queue_failed();
    if (events.readable || events.event) {
      if (std::exchange(empty_wakeups_, true)) clock_.sleep_until(clock_.now() + kRetryPause);
    }
    return {};
  }

  Result<> read_event() {
    v4l2_event event{};
    const int error = buffers_->device().control(VIDIOC_DQEVENT, &event);
    if (error != 0) {
      auto fault = device_fault(error, "VIDIOC_DQEVENT");
      if (fault.kind == FaultKind::disconnected) return fail(std::move(fault));
      watch_events_ = false;
      return {};
    }
    if (event.type == V4L2_EVENT_SOURCE_CHANGE && (event.u.src_change.changes & V4L2_EVENT_SRC_CH_RESOLUTION) != 0)
      return fail(FaultKind::device, "the signal at the camera's input has changed size");
    return {};
  }

  // poll reports the failure; the next exchange gives its reason.
  Result<> queue_failed() {
    auto filled = buffers_->take();
    if (!filled) return fail(filled.error());
    if (*filled) return buffers_->give_back(**filled);
    return fail(FaultKind::device, "the driver's queue has failed");
  }

  // The newest waiting frame, with older ones given back; empty: none.
  Result<std::optional<Frame>> newest() {
    std::optional<V4l2Filled> newest;
    std::uint32_t skipped = 0;
    // Takes at most as many as there are buffers, or a fast camera would keep this loop going.
    for (int i = 0; i < VIDEO_MAX_FRAME; ++i) {
      auto filled = buffers_->take();
      if (!filled) return fail(filled.error());
      if (!*filled) break;
      if (newest) {
        if (newest->index != (*filled)->index)
          if (auto given = buffers_->give_back(*newest); !given) return fail(given.error());
        ++skipped;
      }
      newest = std::move(*filled);
    }
    if (!newest) return std::optional<Frame>{};
    empty_wakeups_ = false;
    return delivered(*newest, skipped);
  }

  Result<std::optional<Frame>> delivered(const V4l2Filled& filled, std::uint32_t skipped) {
    Frame frame;
    frame.metadata = v4l2_metadata(filled, mode_, layout_, clock_);
    frame.metadata.skipped = skipped;
    const bool good = frame.metadata.status == FrameStatus::good;
    if (good && lend_buffers_ && layout_.planes.size() == 1 && buffers_->can_lend()) {
      frame.payload = buffers_->lend(filled);
    } else {
      frame.payload = payload_of(v4l2_bytes(filled, frame.metadata, layout_));
      ++copied_;
      if (auto given = buffers_->give_back(filled); !given) return fail(given.error());
    }
    if (good && lock_white_balance_ && ++good_frames_ >= kSettledFrames && clock_.now() - opened_at_ >= kSettled) {
      lock_white_balance_ = false;
      if (auto locked = lock_v4l2_white_balance(buffers_->device(), mode_); !locked) return fail(locked.error());
    }
    return std::optional(std::move(frame));
  }

  const std::string description_;
  const bool lend_buffers_;
  bool lock_white_balance_;
  CameraMode mode_;
  const V4l2Layout layout_;
  const std::shared_ptr<V4l2Buffers> buffers_;
  bool watch_events_;
  Clock& clock_;
  const Instant opened_at_;
  std::atomic<std::uint64_t> copied_{0};
  int good_frames_ = 0;
  bool empty_wakeups_ = false;
  std::optional<Fault> fault_;
};

Result<> check(const CameraRequest& request) {
  Problems problems;
  if (request.width < 1 || request.height < 1 || request.width > kLargestSide || request.height > kLargestSide)
    problems.add("width, height {}x{}: expected 1 to {} pixels each way", request.width, request.height, kLargestSide);
  if (request.buffers < 3 || request.buffers > 16) problems.add("buffers {}: expected 3 to 16", request.buffers);
  if (!(request.frames_per_second >= 0.0 && request.frames_per_second <= 1000.0))
    problems.add("frames_per_second {}: expected 0 (the camera's highest rate) to 1000", request.frames_per_second);
  if (request.exposure_s && !(*request.exposure_s > 0.0 && *request.exposure_s <= 100.0))
    problems.add("exposure_s {}: expected more than 0, at most 100", *request.exposure_s);
  if (request.gain && !(*request.gain >= 0.0 && *request.gain <= 1e9))
    problems.add("gain {}: expected at least 0", *request.gain);
  if (request.white_balance_k && !(*request.white_balance_k >= 1000.0 && *request.white_balance_k <= 40000.0))
    problems.add("white_balance_k {}: expected 1000 to 40000", *request.white_balance_k);
  if (problems.empty()) return {};
  return fail(problems.fault());
}

// "/dev/video3" may be another camera after the next boot.
void note_number(const std::filesystem::path& path, CameraMode& mode) {
  const auto name = path.filename().string();
  if (path.parent_path() == "/dev" && name.starts_with("video"))
    mode.notes.push_back(
        fmt::format("{}: may be another camera after the next boot; expected a path below /dev/v4l/by-id or by-path",
                    path.string()));
}

Result<std::unique_ptr<CameraSource>> open_stream(std::unique_ptr<VideoDevice> device, const V4l2Options& options,
                                                  Clock& clock) {
  const auto& request = options.request;
  if (auto fine = check(request); !fine) return fail(fine.error());
  auto identity = identify_v4l2(*device);
  if (!identity) return fail(identity.error());
  auto agreement = negotiate_v4l2(*device, *identity, request);
  if (!agreement) return fail(agreement.error());
  auto& mode = agreement->mode;
  note_number(options.device, mode);
  if (auto set = set_v4l2_controls(*device, request, mode); !set) return fail(set.error());
  v4l2_event_subscription subscription{};
  subscription.type = V4L2_EVENT_SOURCE_CHANGE;
  const bool watch_events = device->control(VIDIOC_SUBSCRIBE_EVENT, &subscription) == 0;
  auto buffers = V4l2Buffers::start(std::move(device), agreement->layout, request.buffers);
  if (!buffers) return fail(buffers.error());
  auto description = fmt::format("{} at {}", mode.card, options.device.string());
  return std::make_unique<V4l2Source>(std::move(description), request, std::move(mode), std::move(agreement->layout),
                                      std::move(*buffers), watch_events, clock);
}

}  // namespace

Result<std::unique_ptr<CameraSource>> open_v4l2_source(std::unique_ptr<VideoDevice> device, const V4l2Options& options,
                                                       Clock& clock) {
  auto source = open_stream(std::move(device), options, clock);
  if (!source) return fail(source.error().kind, "{}: {}", options.device.string(), source.error().message);
  return source;
}

Result<std::unique_ptr<CameraSource>> open_v4l2_source(const V4l2Options& options, Clock& clock) {
  auto device = open_video_device(options.device);
  if (!device) return fail(device.error());
  return open_v4l2_source(std::move(*device), options, clock);
}

}  // namespace kasumi
