#include "tests/pipeline/kiosk/appliance/faulty_source.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>

#include "base/unique_fd.hpp"

namespace kasumi {

namespace {

class FaultySource final : public FrameSource {
 public:
  FaultySource(std::unique_ptr<FrameSource> source, CameraFaults& faults, Clock& clock)
      : source_(std::move(source)), faults_(faults), clock_(clock) {}
  std::string description() const override { return source_->description(); }

  Result<Frame> next(Instant deadline) override {
    faults_.trap.enter();
    if (faults_.unplugged || gone_) {
      gone_ = true;  // an unplugged device does not come back under the same descriptor
      return fail(FaultKind::disconnected, "{}: ENODEV", description());
    }
    if (std::exchange(faults_.fatal_queue, false)) return fail(FaultKind::device, "{}: DQBUF: EIO", description());
    auto frame = source_->next(deadline);
    if (!frame) return frame;
    if (faults_.silent) {
      clock_.sleep_until(deadline);
      return fail(FaultKind::timeout, "{}: no frame", description());
    }
    const auto number = frame->metadata.sequence;
    if (faults_.spoil) faults_.spoil(*frame);
    if (faults_.gives && frame->metadata.status == FrameStatus::good) faults_.gives(number);
    return frame;
  }

 private:
  std::unique_ptr<FrameSource> source_;
  CameraFaults& faults_;
  Clock& clock_;
  bool gone_ = false;
};

// Checks the frame again, as the driver's side does.
void give(Frame& frame, std::vector<std::uint8_t> bytes) {
  frame.metadata.bytes_used = static_cast<std::uint32_t>(bytes.size());
  frame.payload = payload_of(std::move(bytes));
  frame.metadata.status = judge(frame.metadata, frame.payload.bytes.size(), false);
}

void fill(Frame& frame, std::uint8_t value) {
  give(frame, std::vector<std::uint8_t>(frame.payload.bytes.size(), value));
}

}  // namespace

void Trap::enter() {
  std::unique_lock lock(mutex_);
  if (!set_) return;
  caught_ = true;
  released_.wait(lock, [&] { return !set_; });
  caught_ = false;
}

void Trap::let_go() {
  const std::lock_guard lock(mutex_);
  set_ = false;
  released_.notify_all();
}

SourceOpener with_faults(SourceOpener opener, CameraFaults& faults, Clock& clock) {
  SourceOpener faulty;
  faulty.name = opener.name;
  faulty.present = [&faults, present = opener.present] { return !faults.unplugged && (!present || present()); };
  faulty.open = [&faults, &clock, open = opener.open]() -> Result<std::unique_ptr<FrameSource>> {
    if (faults.unplugged) return fail(FaultKind::disconnected, "no such device");
    if (!faults.open_fails.empty()) return fail(FaultKind::device, "{}", faults.open_fails);
    auto source = open();
    if (!source) return source;
    ++faults.opened;
    return std::make_unique<FaultySource>(std::move(*source), faults, clock);
  };
  return faulty;
}

void flag_as_error(Frame& frame) {
  frame.metadata.status = FrameStatus::flagged;
}

void truncate(Frame& frame) {
  const auto bytes = frame.payload.bytes.first(frame.payload.bytes.size() / 2);
  give(frame, {bytes.begin(), bytes.end()});
}

void empty(Frame& frame) {
  give(frame, {});
}

void replace_by_rubbish_jpeg(Frame& frame) {
  frame.metadata.format = kMjpg;
  frame.metadata.stride = 0;
  std::vector<std::uint8_t> bytes(20'000);
  std::uint32_t state = frame.metadata.sequence + 1;
  for (auto& byte : bytes) byte = static_cast<std::uint8_t>((state = state * 1664525u + 1013904223u) >> 24);
  bytes[0] = 0xff;
  bytes[1] = 0xd8;
  give(frame, std::move(bytes));
}

std::function<void(Frame&)> freeze() {
  return [kept = std::optional<Payload>()](Frame& frame) mutable {
    if (!kept) kept = frame.payload;
    frame.payload = *kept;
  };
}

void cover(Frame& frame) {
  fill(frame, 2);
}

void white_out(Frame& frame) {
  fill(frame, 255);
}

void cloud_over(Frame& frame) {
  std::vector<std::uint8_t> bytes(frame.payload.bytes.begin(), frame.payload.bytes.end());
  for (auto& byte : bytes) byte = std::min<std::uint8_t>(byte, 110);
  give(frame, std::move(bytes));
}

void halve_size(Frame& frame) {
  frame.metadata.width /= 2;
  frame.metadata.height /= 2;
  frame.metadata.stride /= 2;
  const auto bytes = frame.payload.bytes.first(frame.payload.bytes.size() / 4);
  give(frame, {bytes.begin(), bytes.end()});
}

std::function<void(Frame&)> lend() {
  return [](Frame& frame) {
    auto memory = std::make_shared<UniqueFd>(memfd_create("camera", MFD_CLOEXEC));
    const auto bytes = frame.payload.bytes;
    if (write(memory->value(), bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size())) return;
    frame.payload.dma_buf = DmaBuf{memory->value(), 0, new_buffer_number()};
    frame.payload.holder = std::make_shared<const std::pair<std::shared_ptr<UniqueFd>, std::shared_ptr<const void>>>(
        memory, frame.payload.holder);
  };
}

std::function<void(Frame&)> run_backwards() {
  return [back = false](Frame& frame) mutable {
    back = !back;
    frame.metadata.sequence += back ? 3 : 0;
    if (back) frame.metadata.captured_at -= std::chrono::seconds(7);
  };
}

}  // namespace kasumi
