#include "pipeline/lab/recording/replayed_air.hpp"

#include "estimator/sky/sun.hpp"

namespace kasumi {

using namespace std::chrono_literals;

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

ReplayedAir::ReplayedAir(const Installation& installation)
    : site_(installation.site),
      watch_(installation),
      scene_watch_(installation),
      scene_encoding_(installation.scene.yuv_encoding) {
  const auto& around = installation.surroundings;
  TrackerLimits options;
  options.like = around.air.to_be_found();
  if (around.sky_model == DaylightModel::preetham && !around.air.whole()) papers_.emplace(std::move(options));
}

void ReplayedAir::follow(SkyReport& report, Instant when) const {
  if (papers_) report.air = papers_->at(when);
}

ReplayedFrame ReplayedAir::next_scene_frame(FixtureSources& sources, const std::function<bool()>& over) {
  while (!over()) {
    const auto sky_due = sources.sky->due(), scene_due = sources.scene->due();
    if (!scene_due) return std::nullopt;
    if (sky_due && *sky_due <= *scene_due) {
      take_sky_frame(sources.sky->next(*sky_due + 1s));
      continue;
    }
    auto frame = sources.scene->next(*scene_due + 1s);
    if (const auto sight = sight_due(frame)) {
      look(*sight, above_in(latest_));
      latest_ = watch_.with_air(std::move(latest_), sight->when);
      follow(latest_, sight->when);
    }
    if (frame) place_sun(latest_, frame->metadata.utc, site_);
    return frame;
  }
  return std::nullopt;
}

void ReplayedAir::finish_sky(FixtureSources& sources, const std::function<bool()>& over) {
  while (sources.sky->due() && !over()) take_sky_frame(sources.sky->next(*sources.sky->due() + 1s));
}

std::optional<Sight> ReplayedAir::sight_due(const Result<Frame>& frame) {
  if (!frame || frame->metadata.status != FrameStatus::good || !scene_watch_.any()) return std::nullopt;
  const auto when = frame->metadata.captured_at;
  if (looked_at_ && when >= *looked_at_ && when - *looked_at_ < kSceneLookInterval) return std::nullopt;
  const auto picture = decode(*frame, scene_encoding_);
  if (!picture) return std::nullopt;
  looked_at_ = when;
  return Sight{when, frame->metadata.utc, to_rgb(picture->view())};
}

void ReplayedAir::look(const Sight& sight, const DaylightState& above) {
  watch_.observe(scene_watch_.look(view_of(sight.picture), sight.when, above).air);
  if (!papers_) curve_.add(sight.utc, *watch_.with_air({}, sight.when).air);
}

std::optional<SkyReport> ReplayedAir::observe_sky(Result<Frame> frame) {
  if (!frame) {
    if (frame.error().kind != FaultKind::timeout && frame.error().kind != FaultKind::end_of_stream)
      ++skipped_[fmt::format("sky camera: {}", name_of(frame.error().kind))];
    return std::nullopt;
  }
  ++sky_frames_;
  const auto when = frame->metadata.captured_at;
  auto report = watch_.observe(*frame);
  if (!report) {
    ++skipped_[fmt::format("sky camera: {}",
                           frame->metadata.status == FrameStatus::good ? "damaged" : name_of(frame->metadata.status))];
    return std::nullopt;
  }
  if (papers_) papers_->observe(report->estimate, when);
  follow(*report, when);
  table_.add(*report, site_.altitude_m);
  if (!papers_) curve_.add(report->utc, *report->air);
  if (report->estimate.usable) ++usable_sky_frames_;
  return std::move(*report);
}

void ReplayedAir::take_sky_frame(Result<Frame> frame) {
  if (auto report = observe_sky(std::move(frame))) latest_ = std::move(*report);
}

}  // namespace kasumi
