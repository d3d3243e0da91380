#include "pipeline/scene/sky_watch.hpp"

#include <cmath>

#include "estimator/sky/sun.hpp"

namespace kasumi {

namespace {

// Longer than between two pictures of a slow camera; older clouds have moved on.
constexpr Duration kCloudsHold = std::chrono::minutes(2);

}  // namespace

SkyWatch::SkyWatch(const Installation& installation, SkyWatchOptions options)
    : site_(installation.site),
      object_m_(installation.object.placement.east_m, installation.object.placement.north_m,
                installation.object.placement.up_m),
      cloud_base_m_(installation.surroundings.cloud_base_m),
      given_(installation.surroundings.air),
      options_(std::move(options)),
      observer_(installation.sky) {
  options_.estimate.sky = installation.sky_to_fit();
}

SunCheck SkyWatch::place_sun(Utc utc, const SkyPicture* picture, SunSource sun_from) const {
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
  return cross_check(ephemeris, blob, clock_trusted);
}

void SkyWatch::estimate(const SkyPicture& picture, SkyReport& report) {
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

void SkyWatch::add_air(SkyReport& report, Instant when) const {
  report.tracked = tracker_.at(when);
  if (const auto given = given_.whole()) {
    // Whatever the sky says of it, the air is known.
    const Turbidity turbidity{turbidity_of(*given)};
    report.tracked = TrackedTurbidity{};
    report.tracked->turbidity = report.tracked->target = turbidity;
    report.tracked->trustworthy = true;
    report.air = air_quality(*given, site_.altitude_m);
  } else if (report.tracked) {
    report.air = air_quality(air_of(report.tracked->turbidity, given_.to_be_found()), site_.altitude_m);
  }
}

Result<SkyReport> SkyWatch::observe(const Frame& frame, Instant when, SunSource sun_from) {
  auto decoded = decode(frame, observer_.camera().yuv_encoding);
  if (!decoded) return fail(decoded.error());
  const auto picture = sky_picture(decoded->view(), observer_.camera());
  if (!picture) return fail(picture.error());

  SkyReport report;
  report.utc = frame.metadata.utc;
  report.picture = std::make_shared<const DecodedPicture>(*decoded);
  report.sun = place_sun(report.utc, &*picture, sun_from);
  estimate(*picture, report);
  last_estimate_ = report.estimate;
  last_measured_ = report.measured;
  last_observed_ = when;
  tracker_.observe(report.estimate, when);
  add_air(report, when);
  return report;
}

SkyReport SkyWatch::at(Instant when, Utc utc, SunSource sun_from) const {
  SkyReport report;
  report.utc = utc;
  report.sun = place_sun(utc, nullptr, sun_from);
  report.estimate = last_estimate_;
  if (when - last_observed_ <= kCloudsHold) report.measured = last_measured_;
  add_air(report, when);
  return report;
}

void SkyWatch::remember(Turbidity turbidity, double sigma, Instant when) {
  if (tracker_.at(when)) return;
  TurbidityEstimate earlier;
  earlier.usable = true;
  earlier.turbidity = turbidity;
  earlier.sigma = sigma;
  tracker_.observe(checked(earlier), when);
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
