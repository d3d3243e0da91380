#include "pipeline/show/scene/sky_watch.hpp"

#include <algorithm>
#include <cmath>

#include "estimator/sky/sun.hpp"
#include "pipeline/show/scene/aged_report.hpp"

namespace kasumi {

namespace {

// Of an estimate by one model alone: what it cannot know is as usual.
FoundAerosol found_alone(Turbidity turbidity, double sigma, const ModelToFit& sky) {
  // Of all air: 1.3 +- .4, as SkyFit supposes it of models that know T alone.
  constexpr double kUsualExponent = 1.3, kExponentSigma = 0.4;
  const Aerosol like = sky.aerosol.value_or(Aerosol{0.0, kUsualExponent});
  const AirState air = air_of(turbidity, like, sigma);
  FoundAerosol found{air.aerosol(), air.covariance(), {}, 0.0};
  if (!sky.aerosol) {
    found.covariance.angstrom_exponent = kExponentSigma * kExponentSigma;
    if (sky.model == DaylightModel::preetham) found.papers_share = 1.0;
  } else {
    found.kinds[static_cast<std::size_t>(like.kind)] = 1.0;
  }
  return found;
}

AirTracker tracker_of(const Installation& installation) {
  TrackingRules options;
  options.given = installation.surroundings.air;
  options.altitude_m = installation.site.altitude_m;
  return AirTracker(options);
}

}  // namespace

double SkyWatch::Saturation::at(Instant when) const {
  constexpr double kFollowed_s = 300.0;  // time constant: a new saturation shall not be seen to jump
  const double since_s = std::max(0.0, to_seconds(when - learnt_at));
  return learnt + (before - learnt) * std::exp(-since_s / kFollowed_s);
}

FrameReader::FrameReader(const Installation& installation, ObservationPlan options)
    : site_(installation.site),
      object_m_(installation.object.placement.east_m, installation.object.placement.north_m,
                installation.object.placement.up_m),
      cloud_base_m_(installation.surroundings.cloud_base_m),
      options_(std::move(options)),
      observer_(installation.sky) {
  options_.estimate.sky = installation.model_to_fit();
}

SunCheck FrameReader::place_sun(Utc utc, const SkyPicture* picture, SunSource sun_from) const {
  if (sun_from == SunSource::none) {
    SunCheck unknown;
    unknown.message = "the time is not trusted yet";
    return unknown;
  }
  const bool clock_trusted = sun_from == SunSource::ephemeris;
  std::optional<SunDirection> ephemeris;
  if (clock_trusted) ephemeris = sun_position(utc, site_).direction;
  std::optional<SunBlob> blob;
  if (picture) blob = find_sun(*picture, observer_.camera());
  return cross_check(ephemeris, blob, clock_trusted, picture != nullptr);
}

void FrameReader::estimate(const SkyPicture& picture, SkyReport& report) {
  const SunCheck& sun = report.sun;
  if (sun.source == SunSource::none) {
    report.estimate.reason = "the sun's position is unknown: " + sun.message;
    return;
  }
  if (options_.estimator) {
    report.estimate = checked(options_.estimator(picture, sun.direction));
    return;
  }
  const auto observation = observer_.observe(picture, sun.direction, options_.estimate);
  report.estimate = checked(observation.estimate);
  if (auto sky =
          observer_.measure(picture, observation, towards_shading_cloud(object_m_, sun.direction, cloud_base_m_)))
    report.measured = std::make_shared<const MeasuredSky>(std::move(*sky));
}

Result<SkyReport> FrameReader::read(const Frame& frame, SunSource sun_from) {
  auto decoded = decode(frame, observer_.camera().yuv_encoding);
  if (!decoded) return fail(decoded.error());
  const auto picture = sky_picture(decoded->view(), observer_.camera());
  if (!picture) return fail(picture.error());

  SkyReport report;
  report.utc = frame.metadata.utc;
  report.picture = std::make_shared<const DecodedPicture>(*decoded);
  report.sun = place_sun(report.utc, &*picture, sun_from);
  estimate(*picture, report);
  return report;
}

SkyWatch::SkyWatch(const Installation& installation, ObservationPlan options)
    : reader_(installation, std::move(options)),
      given_(installation.surroundings.air),
      air_(tracker_of(installation)) {}

FoundAerosol SkyWatch::found_in(const TurbidityEstimate& estimate) const {
  return of_site(estimate.found ? *estimate.found : found_alone(estimate.turbidity, estimate.sigma, reader_.sky()));
}

FoundAerosol SkyWatch::of_site(FoundAerosol found) const {
  // Of an aerosol that is known in part T alone says too little.
  if (given_.any()) found.papers_share = 0.0;
  return found;
}

void SkyWatch::add_air(SkyReport& report, Instant when) const {
  if (scene_saturation_) report.scene_saturation = scene_saturation_->at(when);
  report.air = air_.at(when);
}

void SkyWatch::observe(const TrackerReading& scene) {
  if (scene.saturation) {
    const double unlearnt = scene_seen_ ? 1.0 : *scene.saturation;
    scene_saturation_ = {scene_saturation_ ? scene_saturation_->at(scene.when) : unlearnt, *scene.saturation,
                         scene.when};
  }
  scene_seen_ = true;
  if (scene.low_sky) air_.observe(ColumnReading{AirObserver::horizon, of_site(scene.low_sky->found)}, scene.when);
  if (scene.path) air_.observe(*scene.path, scene.when);
}

SkyReport SkyWatch::with_air(SkyReport report, Instant when) const {
  add_air(report, when);
  return report;
}

Result<SkyReport> SkyWatch::observe(const Frame& frame, Instant when, SunSource sun_from) {
  auto read = reader_.read(frame, sun_from);
  if (!read) return read;
  return observe(std::move(*read), when);
}

SkyReport SkyWatch::observe(SkyReport report, Instant when) {
  last_estimate_ = report.estimate;
  last_measured_ = report.measured;
  last_observed_ = when;
  if (report.estimate.usable) air_.observe(ColumnReading{AirObserver::sky, found_in(report.estimate)}, when);
  add_air(report, when);
  return report;
}

SkyReport SkyWatch::at(Instant when, Utc utc, SunSource sun_from) const {
  SkyReport report;
  report.utc = utc;
  report.sun = reader_.place_sun(utc, nullptr, sun_from);
  report.estimate = last_estimate_;
  if (when - last_observed_ <= kCloudsHold) report.measured = last_measured_;
  add_air(report, when);
  return report;
}

std::optional<RememberedAir> SkyWatch::to_remember(Instant when, Utc utc) const {
  return given_.whole() ? std::nullopt : air_.to_remember(when, utc);
}

void SkyWatch::remember(Turbidity turbidity, double sigma, Instant when) {
  TurbidityEstimate earlier;
  earlier.usable = true;
  earlier.turbidity = turbidity;
  earlier.sigma = sigma;
  earlier = checked(earlier);
  if (!earlier.usable) return;
  const FoundAerosol found = found_in(earlier);
  RememberedAir air{found.aerosol, std::sqrt(found.covariance.aod_550), std::sqrt(found.covariance.angstrom_exponent)};
  air.papers_sky = found.papers_share > 0.5;
  air_.remember(air, when);
}

TurbidityEstimate checked(TurbidityEstimate estimate) {
  if (!estimate.usable) return estimate;
  const double t = estimate.turbidity.value, sigma = estimate.sigma;
  const auto& sun = estimate.sun;
  const bool possible = t >= 1.0 && t <= 2.0 * kHighestTurbidity.value && sigma >= 0.0 && std::isfinite(sigma) &&
                        std::isfinite(sun.x + sun.y + sun.z);
  if (possible) return estimate;
  TurbidityEstimate refused;
  refused.sky = estimate.sky;
  refused.reason = fmt::format("rejected: a turbidity of {} +- {} is impossible", t, sigma);
  return refused;
}

}  // namespace kasumi
