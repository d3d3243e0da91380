#include "pipeline/kiosk/appliance/sky_loop.hpp"

#include <algorithm>

#include <spdlog/spdlog.h>

#include "base/outside/abandonable.hpp"
#include "pipeline/kiosk/appliance/status_mailbox.hpp"
#include "pipeline/kiosk/start/remembered_state.hpp"
#include "pipeline/machine/camera_acceptance.hpp"
#include "pipeline/show/scene/aged_report.hpp"

namespace kasumi {

namespace {

using namespace std::chrono_literals;

constexpr Duration kSkyStatusInterval = 1s;  // while no frame comes
constexpr Duration kHealthInterval = 500ms;
constexpr Duration kFirstFrameTimeout = 2s;  // at the start, before a report without a frame
constexpr Duration kMaxStoredAge = 2h;       // older air is not worth restoring

// T of what the sky camera saw last: an aerosol of the exponent that is believed now.
ObservedTurbidity by_sky_alone(const std::optional<TrackedAir>& air) {
  ObservedTurbidity alone;
  const auto trusted = [](const ObserverPart& part) {
    return part.by == AirObserver::sky && part.age <= TrackingRules{}.trusted_for;
  };
  if (!air) return alone;
  const auto sky = std::ranges::find_if(air->observers, trusted);
  if (sky == air->observers.end()) return alone;
  const auto turbidity = [&](double aod_550) {
    return turbidity_of(Aerosol{aod_550, air->air.aerosol().angstrom_exponent});
  };
  alone.turbidity = Turbidity{turbidity(sky->aod_550)};
  alone.sigma = sky->sigma_aod_550 * (turbidity(1.0) - turbidity(0.0));  // T is linear in the optical depth
  return alone;
}

}  // namespace

SkyLoop::SkyLoop(ContentPtr content, Devices& devices, Clock& clock, TimeWatch& time, Mailboxes& mailboxes,
                 ObservationPlan options)
    : content_(std::move(content)),
      devices_(devices),
      clock_(clock),
      time_(time),
      mailboxes_(mailboxes),
      options_(std::move(options)),
      camera_(devices.camera(CameraRole::sky, content_->config.sky_camera), clock),
      trust_(content_->config.clock),
      watch_(content_->config.installation, options_),
      started_(clock.now()) {}

void SkyLoop::step(Instant deadline) {
  mailboxes_.sky.pulse.turn(clock_.now(), deadline - clock_.now() + kWaitingBound);
  adopt_content();
  const auto sun_from = sun_source();
  restore_air();
  if (const auto scene = mailboxes_.sky.scene_air.take()) watch_.observe(*scene);
  const auto frame = camera_.next(deadline);
  const bool good = frame && frame->metadata.status == FrameStatus::good;
  // A frozen picture shows an earlier sky under a sun that moves on.
  if (good && camera_.health().condition != PictureCondition::frozen)
    observe(*frame, sun_from);
  else
    report_without_frame(sun_from);
  publish_health();
}

void SkyLoop::adopt_content() {
  const auto content = mailboxes_.sky.content.take();
  if (!content) return;
  const bool other_camera = (*content)->config.sky_camera != content_->config.sky_camera;
  content_ = *content;
  trust_.adopt(content_->config.clock);
  watch_ = SkyWatch(content_->config.installation, options_);
  air_restored_ = false;
  observed_at_.reset();
  if (other_camera) camera_.replace(devices_.camera(CameraRole::sky, content_->config.sky_camera));
}

SunSource SkyLoop::sun_source() {
  const auto source = trust_.judge(time_.read(), clock_.utc());
  if (source != sun_from_)
    spdlog::info("clock: {}", source == SunSource::ephemeris ? "trusted: the sun's position follows from the time"
                              : source == SunSource::image   ? "not trusted yet: searching for the sun in the picture"
                                                             : "not trusted yet: the sun's position is unknown");
  sun_from_ = source;
  return source;
}

// Its age is known only once the time is.
void SkyLoop::restore_air() {
  const auto& folder = content_->config.state_folder;
  if (air_restored_ || sun_from_ != SunSource::ephemeris || !folder) return;
  air_restored_ = true;
  const auto read = within<Result<TurbidityState>>(2s, [from = *folder] { return load_turbidity_state(from); });
  if (!read) return spdlog::warn("{}: does not answer: the air of before is not known", folder->string());
  const auto& state = *read;
  if (!state) {
    std::error_code error;
    if (std::filesystem::exists(*folder / "turbidity.json", error)) spdlog::warn("{}", state.error().message);
    return;
  }
  const auto age = clock_.utc() - state->utc;
  if (age < Duration{0} || age > kMaxStoredAge) return;
  // T of the other sky model, or of another aerosol, is another quantity.
  if (!state->belongs_to(content_->config.installation.model_to_fit())) return;
  if (state->air)
    watch_.remember(*state->air, clock_.now() - age);
  else
    watch_.remember(state->turbidity, state->sigma, clock_.now() - age);
  spdlog::info("air: turbidity {:.2f} of {:.0f} minutes ago restored", state->turbidity.value, to_seconds(age) / 60);
}

void SkyLoop::observe(const Frame& frame, SunSource sun_from) {
  const auto now = clock_.now();
  if (observed_at_ && now - *observed_at_ < options_.observe_every) return;
  observed_at_ = now;
  mailboxes_.sky.pulse.turn(now, kComputingBound);
  recorded_utc_offset_ = camera_.recorded() ? frame.metadata.utc - clock_.utc() : Duration{0};
  const auto unusable = why_unusable(frame.metadata, content_->config.installation.sky);
  auto report = unusable.empty() ? watch_.observe(frame, now, sun_from) : fail(FaultKind::bad_input, "{}", unusable);
  if (!report) {
    camera_.reject(unusable.empty() ? "damaged" : unusable);
    return report_without_frame(sun_from);
  }
  if (sun_from == SunSource::image) hold_sun(report->sun);
  mailboxes_.check.clock_trusted = sun_from == SunSource::ephemeris;
  if (report->picture && mailboxes_.sky.check_wants_picture.exchange(false))
    mailboxes_.check.sky.put({frame.metadata, to_rgb(report->picture->view()), sun_from == SunSource::ephemeris});
  publish(std::move(*report), true, sun_from);
}

// Clouds hide the sun for minutes; the building must not come and go with them.
void SkyLoop::hold_sun(SunCheck& sun) {
  const auto now = clock_.now();
  if (sun.source == SunSource::image)
    seen_sun_ = {sun, now};
  else if (seen_sun_ && now - seen_sun_->at <= kSunHold)
    sun = seen_sun_->sun;
}

void SkyLoop::report_without_frame(SunSource sun_from) {
  const auto now = clock_.now();
  const auto health = camera_.health();
  if (!observed_at_ && now - started_ < kFirstFrameTimeout && health.cause.empty()) return;
  if (published_at_ && now - *published_at_ < kSkyStatusInterval) return;
  auto report = watch_.at(now, clock_.utc() + recorded_utc_offset_, sun_from);
  if (sun_from == SunSource::image) hold_sun(report.sun);
  const bool up = health.up && health.condition != PictureCondition::frozen;
  if (!up) {
    report.estimate.usable = false;
    report.estimate.reason = fmt::format("no picture of the sky: {}", health.up ? "frozen" : health.cause);
  }
  publish(std::move(report), up, sun_from);
}

void SkyLoop::publish(SkyReport report, bool up, SunSource sun_from) {
  published_at_ = clock_.now();
  SkyStatus status{std::move(report), up, sun_from == SunSource::ephemeris,
                   watch_.to_remember(*published_at_, clock_.utc()), *published_at_};
  ObservedTurbidity air = by_sky_alone(status.report.air);
  air.above.sky = status.report.estimate.sky;
  air.told = *published_at_;
  if (status.sun_known()) air.above.sun = status.report.sun.direction;
  mailboxes_.visibility.sky.put(std::move(air));
  mailboxes_.status->sky.put(status);
  mailboxes_.render.sky.put(std::move(status));
}

void SkyLoop::publish_health() {
  const auto now = clock_.now();
  if (health_published_at_ && now - *health_published_at_ < kHealthInterval) return;
  health_published_at_ = now;
  mailboxes_.status->sky_camera.put(camera_.status());
}

}  // namespace kasumi
