#include "capture/reconnecting_source.hpp"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <random>

namespace kasumi {

namespace {

constexpr Duration kPresenceInterval = std::chrono::milliseconds(200);
constexpr Duration kShortestBackoff = std::chrono::milliseconds(10);  // even if the options ask for less

// How long to wait before each attempt.
class Backoff {
 public:
  explicit Backoff(const ReconnectTimes& options)
      : first_(std::max(options.first_backoff, kShortestBackoff)),
        longest_(std::max(options.longest_backoff, first_)),
        jitter_(std::clamp(options.jitter, 0.0, 1.0)),
        random_(options.seed) {}

  Duration next() {
    nominal_ = nominal_ == Duration::zero() ? first_ : std::min(2 * nominal_, longest_);
    const double unit = static_cast<double>(random_() >> 11) * 0x1p-53;  // 0 .. 1
    return from_seconds(to_seconds(nominal_) * (1.0 + jitter_ * (2.0 * unit - 1.0)));
  }
  // The backoff keeps growing while the camera stays up for less than it waited.
  void was_up(Duration time) {
    if (time > nominal_) restart();
  }
  void restart() { nominal_ = Duration::zero(); }

 private:
  Duration first_, longest_;
  double jitter_;
  std::mt19937_64 random_;
  Duration nominal_{};
};

class Reconnecting final : public ReconnectingSource {
 public:
  Reconnecting(SourceOpener opener, Clock& clock, const ReconnectTimes& options)
      : opener_(std::move(opener)),
        clock_(clock),
        options_(options),
        backoff_(options),
        watch_(options.condition_deadline) {}

  std::string description() const override { return opener_.name; }

  CameraHealth health() const override {
    const std::lock_guard lock(mutex_);
    return health_;
  }

  void reject(std::string_view reason) override {
    if (!undecided_) return;
    undecided_.reset();
    if (!bad_since_) bad_since_ = last_frame_at_;
    const std::lock_guard lock(mutex_);
    --health_.good_frames;
    ++health_.bad_frames[why_bad_ = reason];
    health_.last_good = accepted_at_;
  }

  Result<Frame> next(Instant deadline) override {
    accept();
    while (true) {
      if (!source_) {
        if (auto opened = wait_and_open(deadline); !opened) return fail(opened.error());
        continue;
      }
      if (bad_since_ && last_frame_at_ - *bad_since_ >= options_.bad_frames_deadline)
        return close("bad frames",
                     fmt::format("no good frame for {:.1f} s{}{}", to_seconds(last_frame_at_ - *bad_since_),
                                 why_bad_.empty() ? "" : ": ", why_bad_));
      const auto watched_until =
          last_frame_at_ + (frames_came_ ? options_.stall_deadline : options_.first_frame_deadline);
      auto frame = source_->next(std::min(deadline, watched_until));
      if (frame) {
        received(*frame);
        return frame;
      }
      switch (frame.error().kind) {
        case FaultKind::end_of_stream: return frame;
        case FaultKind::disconnected: return close("unplugged", "unplugged");
        case FaultKind::timeout: break;
        default: return close("fatal", frame.error().message);
      }
      if (clock_.now() < watched_until) return fail(FaultKind::timeout, "{}: no frame", opener_.name);
      if (frames_came_)
        return close("stall", fmt::format("stalled: no frame for {:.1f} s", to_seconds(options_.stall_deadline)));
      return close("first frame",
                   fmt::format("first frame: none for {:.1f} s", to_seconds(options_.first_frame_deadline)));
    }
  }

 private:
  // Waits for the next attempt and makes it. Faults: timeout, or disconnected when the first attempt fails; after later
  // failures there is no source yet and no fault.
  Result<> wait_and_open(Instant deadline) {
    while (true) {
      const auto now = clock_.now();
      if (reappeared() || now >= retry_at_) return open();
      if (now >= deadline) return fail(FaultKind::timeout, "{}: {}", opener_.name, cause_);
      auto until = std::min(deadline, retry_at_);
      if (opener_.present) until = std::min(until, now + kPresenceInterval);
      clock_.sleep_until(until);
      if (clock_.now() < until) return fail(FaultKind::timeout, "{}: interrupted", opener_.name);
    }
  }

  bool reappeared() {
    if (!opener_.present || !down_since_) return false;
    const bool was_present = std::exchange(present_, opener_.present());
    if (was_present || !present_) return false;
    backoff_.restart();
    return true;
  }

  Result<> open() {
    auto opened = opener_.open();
    const auto now = clock_.now();  // opening a camera takes a while
    if (!opened) {
      const bool first = !down_since_;
      down(opened.error().kind == FaultKind::disconnected ? "unplugged" : opened.error().message);
      if (!first) return {};
      return fail(FaultKind::disconnected, "{}: {}", opener_.name, cause_);
    }
    source_ = std::move(*opened);
    camera_ = dynamic_cast<const CameraSource*>(source_.get());
    last_frame_at_ = now;
    frames_came_ = false;
    bad_since_.reset();
    last_sequence_.reset();
    last_captured_at_.reset();
    sampled_at_.reset();
    up_since_.reset();
    watch_.reopened();
    const std::lock_guard lock(mutex_);
    ++health_.opened;
    if (!closed_by_.empty()) ++health_.reopened[std::exchange(closed_by_, {})];
    update_camera();
    return {};
  }

  tl::unexpected<Fault> close(std::string closed_by, std::string cause) {
    if (up_since_) backoff_.was_up(accepted_at_.value_or(Instant{}) - *up_since_);
    {
      const std::lock_guard lock(mutex_);
      update_camera();
      copied_before_ = health_.frames_copied;
    }
    camera_ = nullptr;
    source_.reset();
    closed_by_ = std::move(closed_by);
    down(std::move(cause));
    return fail(FaultKind::disconnected, "{}: {}", opener_.name, cause_);
  }

  void down(std::string cause) {
    const auto now = clock_.now();
    if (!down_since_) {
      down_since_ = now;
      present_ = opener_.present && opener_.present();
    }
    retry_at_ = now + backoff_.next();
    cause_ = std::move(cause);
    const std::lock_guard lock(mutex_);
    health_.up = false;
    health_.cause = cause_;
    health_.down_since = down_since_;
  }

  // By asking for another frame the reader accepts the last one.
  void accept() {
    if (!undecided_) return;
    accepted_at_ = *undecided_;
    undecided_.reset();
    bad_since_.reset();
  }

  void received(const Frame& frame) {
    const auto now = clock_.now();
    const auto& metadata = frame.metadata;
    const bool good = metadata.status == FrameStatus::good;
    last_frame_at_ = now;
    frames_came_ = true;
    const bool sample = good && (!sampled_at_ || now - *sampled_at_ >= options_.condition_interval);
    const auto condition = sample ? condition_of(frame, now) : std::nullopt;

    const std::lock_guard lock(mutex_);
    count_order(metadata);
    if (condition) health_.condition = *condition;
    if (sample) update_camera();
    if (!good) {
      ++health_.bad_frames[why_bad_ = name_of(metadata.status)];
      if (!bad_since_) bad_since_ = now;
      return;
    }
    ++health_.good_frames;
    health_.last_good = undecided_ = now;
    count_mode(metadata);
    if (std::exchange(health_.up, true)) return;
    up_since_ = now;
    cause_.clear();
    health_.cause.clear();
    if (down_since_) health_.last_outage = now - *down_since_;
    down_since_.reset();
    health_.down_since.reset();
  }

  // Empty: the frame cannot be decoded, which the reader will find too.
  std::optional<PictureCondition> condition_of(const Frame& frame, Instant now) {
    sampled_at_ = now;
    const auto picture = decode(frame, YuvEncoding::bt601_full);
    if (!picture) return std::nullopt;
    return watch_.observe(sample_picture(picture->view()), now);
  }

  void count_order(const FrameMetadata& metadata) {
    if (last_captured_at_ && metadata.captured_at < *last_captured_at_) ++health_.backwards;
    last_captured_at_ = metadata.captured_at;
    health_.skipped += metadata.skipped;
    // Counts modulo 2^32, so that a wrapping counter shows no gap. A counter that restarts is not counted as a gap.
    const std::uint32_t step = last_sequence_ ? metadata.sequence - *last_sequence_ : 1;
    if (step >= 2 && step < 1u << 31) health_.sequence_gaps += step - 1 - std::min(step - 1, metadata.skipped);
    last_sequence_ = metadata.sequence;
  }

  void count_mode(const FrameMetadata& metadata) {
    const bool same =
        health_.format == metadata.format && health_.width == metadata.width && health_.height == metadata.height;
    if (health_.format && !same) ++health_.mode_changes;
    health_.format = metadata.format;
    health_.width = metadata.width;
    health_.height = metadata.height;
  }

  void update_camera() {
    if (!camera_) return;
    health_.mode = camera_->mode();
    health_.frames_copied = copied_before_ + camera_->frames_copied();
  }

  const SourceOpener opener_;
  Clock& clock_;
  const ReconnectTimes options_;
  Backoff backoff_;
  ConditionWatch watch_;

  std::unique_ptr<FrameSource> source_;
  const CameraSource* camera_ = nullptr;  // source_, if it is a CameraSource
  std::uint64_t copied_before_ = 0;       // by earlier sources
  Instant last_frame_at_{};               // good or bad; before the first frame: when the source was opened
  bool frames_came_ = false;
  std::optional<Instant> undecided_;    // arrival of the last frame if it was good; the reader may still reject it
  std::optional<Instant> accepted_at_;  // arrival of the good frame before it
  std::optional<Instant> bad_since_;
  std::string why_bad_;  // the last one was
  std::optional<Instant> up_since_;
  std::optional<Instant> sampled_at_;
  std::optional<std::uint32_t> last_sequence_;
  std::optional<Instant> last_captured_at_;

  Instant retry_at_ = Instant::min();
  std::optional<Instant> down_since_;
  std::string cause_;
  std::string closed_by_;
  bool present_ = false;

  mutable std::mutex mutex_;
  CameraHealth health_;  // also read by other threads
};

}  // namespace

std::unique_ptr<ReconnectingSource> reconnecting(SourceOpener opener, Clock& clock, ReconnectTimes options) {
  return std::make_unique<Reconnecting>(std::move(opener), clock, options);
}

}  // namespace kasumi
