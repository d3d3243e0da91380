#include "pipeline/appliance/sky_loop.hpp"

#include <spdlog/spdlog.h>

#include "pipeline/appliance/remembered_state.hpp"
#include "pipeline/appliance/status_mail.hpp"

namespace kasumi {

namespace {

using namespace std::chrono_literals;

constexpr Duration kLookInterval = 1s;     // air changes in minutes
constexpr Duration kTellSkyInterval = 1s;  // while no frame comes
constexpr Duration kHealthInterval = 500ms;
constexpr Duration kFirstFramePatience = 2s;  // at the start, before the air is said to be known without a frame
constexpr Duration kSeenSunHolds = 10min;     // it moves 2.5 degrees in that
constexpr Duration kYoungAir = 2h;            // what was written to disk is worth remembering

}  // namespace

SkyLoop::SkyLoop(ContentPtr content, Devices& devices, Clock& clock, TimeWatch& time, Exchange& exchange,
                 SkyWatchOptions options)
    : content_(std::move(content)),
      devices_(devices),
      clock_(clock),
      time_(time),
      exchange_(exchange),
      options_(std::move(options)),
      camera_(devices.camera(CameraRole::sky, content_->config.sky_camera), clock),
      trust_(content_->config.clock),
      watch_(content_->config.installation, options_),
      started_(clock.now()) {}

void SkyLoop::step(Instant deadline) {
  take_content();
  const auto sun_from = sun_source();
  remember_air();
  const auto frame = camera_.next(deadline);
  const bool good = frame && frame->metadata.status == FrameStatus::good;
  // A frozen picture shows an earlier sky under a sun that moves on.
  if (good && camera_.health().condition != PictureCondition::frozen)
    look(*frame, sun_from);
  else
    go_without(sun_from);
  tell_health();
}

void SkyLoop::take_content() {
  const auto content = exchange_.sky.content.take();
  if (!content) return;
  const bool other_camera = (*content)->config.sky_camera != content_->config.sky_camera;
  content_ = *content;
  trust_ = TimeTrust(content_->config.clock);
  watch_ = SkyWatch(content_->config.installation, options_);
  air_remembered_ = false;
  looked_at_.reset();
  if (other_camera) camera_.replace(devices_.camera(CameraRole::sky, content_->config.sky_camera));
}

SunSource SkyLoop::sun_source() {
  const auto source = trust_.judge(time_.look(), clock_.utc());
  if (source != sun_from_)
    spdlog::info("clock: {}", source == SunSource::ephemeris ? "believed: the sun stands where the time says"
                              : source == SunSource::image   ? "not believed yet: the sun is looked for in the picture"
                                                             : "not believed yet: nothing is made of the sun");
  sun_from_ = source;
  return source;
}

// How old it is can be told only once the time is known.
void SkyLoop::remember_air() {
  const auto& folder = content_->config.state_folder;
  if (air_remembered_ || sun_from_ != SunSource::ephemeris || !folder) return;
  air_remembered_ = true;
  const auto state = load_turbidity_state(*folder);
  if (!state) {
    std::error_code error;
    if (std::filesystem::exists(*folder / "turbidity.json", error)) spdlog::warn("{}", state.error().message);
    return;
  }
  const auto age = clock_.utc() - state->utc;
  if (age < Duration{0} || age > kYoungAir) return;
  // The other model's T is another quantity.
  if (state->sky_model != content_->config.installation.sky_to_fit().model) return;
  watch_.remember(state->turbidity, state->sigma, clock_.now() - age);
  spdlog::info("air: turbidity {:.2f} of {:.0f} minutes ago remembered", state->turbidity.value, to_seconds(age) / 60);
}

void SkyLoop::look(const Frame& frame, SunSource sun_from) {
  const auto now = clock_.now();
  if (looked_at_ && now - *looked_at_ < kLookInterval) return;
  looked_at_ = now;
  recorded_utc_offset_ = camera_.recorded() ? frame.metadata.utc - clock_.utc() : Duration{0};
  auto report = watch_.observe(frame, now, sun_from);
  if (!report) {
    camera_.reject("damaged");
    return go_without(sun_from);
  }
  if (sun_from == SunSource::image) hold_sun(report->sun);
  exchange_.check.clock_trusted = sun_from == SunSource::ephemeris;
  if (report->picture && exchange_.sky.check_wants_picture.exchange(false))
    exchange_.check.sky.put({frame.metadata, to_rgb(report->picture->view()), sun_from == SunSource::ephemeris});
  tell(std::move(*report), true, sun_from);
}

// Clouds hide the sun for minutes; the building does not come and go with them.
void SkyLoop::hold_sun(SunCheck& sun) {
  const auto now = clock_.now();
  if (sun.source == SunSource::image)
    seen_sun_ = {sun, now};
  else if (seen_sun_ && now - seen_sun_->at <= kSeenSunHolds)
    sun = seen_sun_->sun;
}

void SkyLoop::go_without(SunSource sun_from) {
  const auto now = clock_.now();
  const auto health = camera_.health();
  if (!looked_at_ && now - started_ < kFirstFramePatience && health.cause.empty()) return;
  if (told_ && now - *told_ < kTellSkyInterval) return;
  auto report = watch_.at(now, clock_.utc() + recorded_utc_offset_, sun_from);
  if (sun_from == SunSource::image) hold_sun(report.sun);
  const bool up = health.up && health.condition != PictureCondition::frozen;
  if (!up) {
    report.estimate.usable = false;
    report.estimate.reason = fmt::format("no picture of the sky: {}", health.up ? "frozen" : health.cause);
  }
  tell(std::move(report), up, sun_from);
}

void SkyLoop::tell(SkyReport report, bool up, SunSource sun_from) {
  told_ = clock_.now();
  SkyNews news{std::move(report), up, sun_from == SunSource::ephemeris};
  const auto& tracked = news.report.tracked;
  SkyAir air{tracked && tracked->trustworthy ? tracked : std::nullopt, std::nullopt};
  if (news.sun_known()) air.sun = news.report.sun.direction;
  exchange_.visibility.sky.put(std::move(air));
  exchange_.status->sky.put(news);
  exchange_.render.sky.put(std::move(news));
}

void SkyLoop::tell_health() {
  const auto now = clock_.now();
  if (told_health_ && now - *told_health_ < kHealthInterval) return;
  told_health_ = now;
  exchange_.status->sky_camera.put(camera_.news());
}

}  // namespace kasumi
