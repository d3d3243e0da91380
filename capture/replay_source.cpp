#include "capture/replay_source.hpp"

#include <algorithm>
#include <unordered_map>

#include "capture/fixture.hpp"
#include "capture/payload_cache.hpp"

namespace kasumi {

Instant ReplayTimeline::on_clock(Instant recorded, const Clock& clock) {
  const std::lock_guard lock(mutex_);
  if (!starts_at_) starts_at_ = clock.now();
  return *starts_at_ + (recorded - first_);
}

namespace {

using Rows = std::vector<IndexRow>;

// From the earliest instant of all recordings to one frame interval past the latest.
std::shared_ptr<ReplayTimeline> timeline_over(std::initializer_list<const Rows*> recordings,
                                              std::optional<Instant> starts_at) {
  Instant first = Instant::max(), last = Instant::min();
  Duration interval = std::chrono::milliseconds{1};
  for (const auto* rows : recordings) {
    const auto [earliest, latest] = std::minmax_element(rows->begin(), rows->end(), [](const auto& a, const auto& b) {
      return a.metadata.captured_at < b.metadata.captured_at;
    });
    first = std::min(first, rows->front().metadata.captured_at);
    last = std::max(last, latest->metadata.captured_at);
    interval = std::max(interval, (latest->metadata.captured_at - earliest->metadata.captured_at) /
                                      static_cast<Duration::rep>(std::max<std::size_t>(1, rows->size() - 1)));
  }
  return std::make_shared<ReplayTimeline>(first, last - first + interval, starts_at);
}

class Replay final : public ReplaySource {
 public:
  Replay(const std::filesystem::path& folder, std::string description, Rows rows, Clock& clock,
         std::shared_ptr<ReplayTimeline> timeline, bool loop)
      : description_(std::move(description)),
        rows_(std::move(rows)),
        clock_(clock),
        timeline_(std::move(timeline)),
        loop_(loop),
        payloads_(folder) {
    for (const auto& row : rows_) ++uses_[row.payload];
    const auto is_frame = [](const IndexRow& row) { return !row.disconnected; };
    const auto first = std::find_if(rows_.begin(), rows_.end(), is_frame);
    const auto last = std::find_if(rows_.rbegin(), rows_.rend(), is_frame);
    if (first != rows_.end()) sequences_ = last->metadata.sequence - first->metadata.sequence + 1;
  }

  std::string description() const override { return description_; }
  std::size_t row_count() const override { return rows_.size(); }

  std::optional<Instant> due() override {
    if (position_ == rows_.size()) return std::nullopt;
    return std::max(last_due_, timeline_->on_clock(recorded_instant(), clock_));
  }

  Result<Frame> next(Instant deadline) override {
    const auto at = due();
    if (!at) return fail(FaultKind::end_of_stream, "{}: the recording has ended", description_);
    if (clock_.now() < *at) {
      clock_.sleep_until(std::min(*at, deadline));
      if (clock_.now() < *at) return gone_ ? disconnected() : fail(FaultKind::timeout, "{}: no frame", description_);
    }
    last_due_ = *at;
    const auto& row = rows_[position_];
    auto frame = row.disconnected ? disconnected() : frame_of(row);
    gone_ = row.disconnected;
    advance();
    return frame;
  }

 private:
  Instant recorded_instant() const { return rows_[position_].metadata.captured_at + round_ * timeline_->period(); }

  tl::unexpected<Fault> disconnected() const { return fail(FaultKind::disconnected, "{}: disconnected", description_); }

  Result<Frame> frame_of(const IndexRow& row) {
    auto payload = payloads_.read(row.payload, row.metadata.bytes_used, loop_ || uses_[row.payload] > 1);
    if (!payload) return fail(payload.error());
    Frame frame{row.metadata, std::move(*payload)};
    frame.metadata.captured_at = recorded_instant();
    frame.metadata.sequence += static_cast<std::uint32_t>(round_) * sequences_;
    frame.metadata.status =
        judge(row.metadata, frame.payload.bytes.size(), row.metadata.status == FrameStatus::flagged);
    return frame;
  }

  void advance() {
    if (++position_ < rows_.size() || !loop_) return;
    position_ = 0;
    ++round_;
  }

  std::string description_;
  Rows rows_;
  Clock& clock_;
  std::shared_ptr<ReplayTimeline> timeline_;
  bool loop_;
  PayloadCache payloads_;
  std::unordered_map<std::string, int> uses_;
  std::uint32_t sequences_ = 1;  // by how much the counter runs on with each round
  std::size_t position_ = 0;
  Duration::rep round_ = 0;
  bool gone_ = false;
  Instant last_due_ = Instant::min();
};

Result<Rows> read_rows(const std::filesystem::path& camera_folder) {
  auto rows = read_index(camera_folder);
  if (rows && rows->empty())
    return fail(FaultKind::bad_input, "{}: expected at least one whole row", (camera_folder / "index.csv").string());
  return rows;
}

}  // namespace

Result<std::unique_ptr<ReplaySource>> open_replay(const std::filesystem::path& camera_folder, Clock& clock,
                                                  const ReplayOptions& options) {
  auto rows = read_rows(camera_folder);
  if (!rows) return fail(rows.error());
  auto timeline = options.timeline ? options.timeline : timeline_over({&*rows}, options.starts_at);
  return std::make_unique<Replay>(camera_folder, fmt::format("recording {}", camera_folder.string()), std::move(*rows),
                                  clock, std::move(timeline), options.loop);
}

Result<FixtureSources> open_fixture_sources(const std::filesystem::path& fixture_folder, Clock& clock,
                                            const ReplayOptions& options) {
  auto sky = read_rows(fixture_folder / "sky"), scene = read_rows(fixture_folder / "scene");
  Problems problems;
  if (!sky) problems.add("{}", sky.error().message);
  if (!scene) problems.add("{}", scene.error().message);
  if (!problems.empty()) return fail(problems.fault());
  const auto timeline = options.timeline ? options.timeline : timeline_over({&*sky, &*scene}, options.starts_at);
  const auto source = [&](std::string_view camera, Rows& rows) {
    return std::make_unique<Replay>(fixture_folder / camera,
                                    fmt::format("fixture {}, {} camera", fixture_folder.filename().string(), camera),
                                    std::move(rows), clock, timeline, options.loop);
  };
  return FixtureSources{source("sky", *sky), source("scene", *scene)};
}

}  // namespace kasumi
