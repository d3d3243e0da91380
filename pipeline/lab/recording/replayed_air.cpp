#include "pipeline/lab/recording/replayed_air.hpp"

#include <algorithm>
#include <thread>
#include <utility>

#include "estimator/sky/sun.hpp"

namespace kasumi {

using namespace std::chrono_literals;

namespace {

constexpr std::size_t kMostAhead = 8;  // frames of both cameras, as large as pictures

}  // namespace

DaylightState above_in(const SkyReport& report) {
  const bool sun_known = report.sun.source != SunSource::none;
  return {sun_known ? std::optional(report.sun.direction) : std::nullopt, report.estimate.sky};
}

void place_sun(SkyReport& report, Utc utc, const Site& site) {
  if (report.picture) return;
  report.sun.source = SunSource::ephemeris;
  report.sun.direction = sun_position(utc, site).direction;
  report.sun.message = "by the recording's time";
}

ReplayedAir::ReplayedAir(const Installation& installation, StageTimes& times)
    : times_(times),
      site_(installation.site),
      watch_(installation),
      scene_watch_(installation),
      scene_encoding_(installation.scene.yuv_encoding) {
  const auto& around = installation.surroundings;
  TrackerLimits options;
  options.like = around.air.to_be_found();
  if (around.sky_model == DaylightModel::preetham && !around.air.whole()) papers_.emplace(std::move(options));
  const std::size_t cores = std::clamp<std::size_t>(std::thread::hardware_concurrency(), 2, kMostAhead / 2);
  for (std::size_t i = 0; i < cores; ++i) readers_.emplace_back(installation);
}

void ReplayedAir::follow(SkyReport& report, Instant when) const {
  if (papers_) report.air = papers_->at(when);
}

ReplayedAir::FrameAhead ReplayedAir::ahead_of_sky(Result<Frame> frame) {
  FrameAhead ahead{std::move(frame), true};
  if (!ahead.frame) return ahead;
  FrameReader& reader = readers_[next_reader_++ % readers_.size()];
  ahead.read = std::async(std::launch::async, [this, &reader, frame = *ahead.frame] {
    const auto started = StageTimes::now();
    auto read = reader.read(frame, SunSource::ephemeris);
    times_.add(ReplayStage::air, started);
    return read;
  });
  return ahead;
}

ReplayedAir::FrameAhead ReplayedAir::ahead_of_scene(Result<Frame> frame) {
  FrameAhead ahead{std::move(frame), false};
  if (!ahead.frame) return ahead;
  ahead.picture = std::async(std::launch::async, [this, frame = *ahead.frame] {
    const auto started = StageTimes::now();
    auto picture = decode(frame, scene_encoding_);
    times_.add(ReplayStage::decoding, started);
    return picture;
  });
  return ahead;
}

void ReplayedAir::read_ahead(FixtureSources& sources) {
  while (ahead_.size() < kMostAhead) {
    const auto sky_due = sources.sky->due(), scene_due = sources.scene->due();
    if (sky_due && (!scene_due || *sky_due <= *scene_due)) {
      if (sky_ahead_ == readers_.size()) return;
      ahead_.push_back(ahead_of_sky(sources.sky->next(*sky_due + 1s)));
      ++sky_ahead_;
    } else if (scene_due) {
      ahead_.push_back(ahead_of_scene(sources.scene->next(*scene_due + 1s)));
    } else {
      return;
    }
  }
}

ReplayedFrame ReplayedAir::next_scene_frame(FixtureSources& sources, const std::function<bool()>& over) {
  while (!over()) {
    read_ahead(sources);
    if (!sources.scene->due() && std::ranges::none_of(ahead_, [](const auto& ahead) { return !ahead.of_sky; }))
      return std::nullopt;
    auto next = std::move(ahead_.front());
    ahead_.pop_front();
    if (next.of_sky) {
      take_sky_frame(std::move(next));
      continue;
    }
    auto picture = next.picture.valid() ? next.picture.get() : Result<DecodedPicture>(fail(next.frame.error()));
    const auto started = StageTimes::now();
    const auto sight = is_sight_due(next.frame) ? sight_of(next.frame->metadata, picture) : std::nullopt;
    if (sight) {
      look(*sight, above_in(latest_));
      latest_ = watch_.with_air(std::move(latest_), sight->when);
      follow(latest_, sight->when);
    }
    if (next.frame) place_sun(latest_, next.frame->metadata.utc, site_);
    times_.add(ReplayStage::air, started);
    return FrameUnderAir{std::move(next.frame), std::move(picture), latest_};
  }
  return std::nullopt;
}

void ReplayedAir::finish_sky(FixtureSources& sources, const std::function<bool()>& over) {
  for (read_ahead(sources); !ahead_.empty() && !over(); read_ahead(sources)) {
    auto next = std::move(ahead_.front());
    ahead_.pop_front();
    if (next.of_sky) take_sky_frame(std::move(next));
  }
}

std::optional<Sight> ReplayedAir::sight_due(const Result<Frame>& frame) {
  return is_sight_due(frame) ? sight_of(frame->metadata, decode(*frame, scene_encoding_)) : std::nullopt;
}

bool ReplayedAir::is_sight_due(const Result<Frame>& frame) const {
  if (!frame || frame->metadata.status != FrameStatus::good || !scene_watch_.any()) return false;
  const auto when = frame->metadata.captured_at;
  return !looked_at_ || when < *looked_at_ || when - *looked_at_ >= kSceneLookInterval;
}

std::optional<Sight> ReplayedAir::sight_of(const FrameMetadata& metadata, const Result<DecodedPicture>& picture) {
  if (!picture) return std::nullopt;
  looked_at_ = metadata.captured_at;
  return Sight{metadata.captured_at, metadata.utc, to_rgb(picture->view())};
}

void ReplayedAir::look(const Sight& sight, const DaylightState& above) {
  watch_.observe(scene_watch_.look(view_of(sight.picture), sight.when, above).air);
  if (!papers_) curve_.add(sight.utc, *watch_.with_air({}, sight.when).air);
}

std::optional<SkyReport> ReplayedAir::observe_sky(const Result<Frame>& frame) {
  if (!frame) return observe_sky(frame, fail(frame.error()));
  return observe_sky(frame, readers_.front().read(*frame, SunSource::ephemeris));
}

std::optional<SkyReport> ReplayedAir::observe_sky(const Result<Frame>& frame, Result<SkyReport> read) {
  if (!frame) {
    if (frame.error().kind != FaultKind::timeout && frame.error().kind != FaultKind::end_of_stream)
      ++skipped_[fmt::format("sky camera: {}", name_of(frame.error().kind))];
    return std::nullopt;
  }
  ++sky_frames_;
  const auto when = frame->metadata.captured_at;
  if (!read) {
    ++skipped_[fmt::format("sky camera: {}",
                           frame->metadata.status == FrameStatus::good ? "damaged" : name_of(frame->metadata.status))];
    return std::nullopt;
  }
  auto report = watch_.observe(std::move(*read), when);
  if (papers_) papers_->observe(report.estimate, when);
  follow(report, when);
  table_.add(report, site_.altitude_m);
  if (!papers_) curve_.add(report.utc, *report.air);
  if (report.estimate.usable) ++usable_sky_frames_;
  return report;
}

void ReplayedAir::take_sky_frame(FrameAhead ahead) {
  --sky_ahead_;
  auto read = ahead.read.valid() ? ahead.read.get() : Result<SkyReport>(fail(ahead.frame.error()));
  const auto started = StageTimes::now();
  if (auto report = observe_sky(ahead.frame, std::move(read))) latest_ = std::move(*report);
  times_.add(ReplayStage::air, started);
}

}  // namespace kasumi
