#include "pipeline/machine/replay_camera.hpp"

#include <algorithm>

#include "base/statistics.hpp"
#include "capture/fixture/fixture.hpp"

namespace kasumi {

namespace {

constexpr Duration kMaxLateness = std::chrono::seconds(1);  // frames overdue by more are skipped

class LiveRecording final : public FrameSource {
 public:
  LiveRecording(std::string name, std::function<Result<std::shared_ptr<ReplaySource>>()> recording, Clock& clock)
      : name_(std::move(name)), recording_(std::move(recording)), clock_(clock) {}
  std::string description() const override { return source_ ? source_->description() : name_; }

  Result<Frame> next(Instant deadline) override {
    if (!source_) {
      auto source = recording_();
      if (!source) return fail(source.error());
      source_ = std::move(*source);
    }
    auto due = source_->due();
    for (; due && clock_.now() - *due > kMaxLateness; due = source_->due()) source_->skip();
    auto frame = source_->next(deadline);
    if (!frame) return frame;
    auto& captured_at = frame->metadata.captured_at;
    if (!offset_) offset_ = *due - captured_at;
    captured_at += *offset_;
    return frame;
  }

 private:
  std::string name_;
  std::function<Result<std::shared_ptr<ReplaySource>>()> recording_;
  Clock& clock_;
  std::shared_ptr<ReplaySource> source_;
  std::optional<Duration> offset_;  // from the recorder's clock to this one
};

}  // namespace

SourceOpener replay_camera(std::string name, std::function<Result<std::shared_ptr<ReplaySource>>()> recording,
                           Clock& clock) {
  auto source = std::make_unique<LiveRecording>(name, std::move(recording), clock);
  return reopening(std::move(name), std::move(source), clock);
}

Duration median_interval(const std::filesystem::path& camera_folder) {
  const auto rows = read_index(camera_folder);
  if (!rows) return Duration{0};
  std::vector<Duration> intervals;
  for (std::size_t i = 1; i < rows->size(); ++i)
    intervals.push_back((*rows)[i].metadata.captured_at - (*rows)[i - 1].metadata.captured_at);
  return std::max(Duration{0}, median(std::move(intervals)));
}

}  // namespace kasumi
