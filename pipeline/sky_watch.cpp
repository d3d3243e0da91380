#include "pipeline/sky_watch.hpp"

#include "estimator/sun.hpp"

namespace kasumi {

SkyWatch::SkyWatch(const Installation& installation, SkyWatchOptions options)
    : site_(installation.site), options_(options), observer_(installation.sky) {}

SunCheck SkyWatch::find_sun_for(Utc utc, const SkyPicture& picture) const {
  std::optional<SunDirection> ephemeris;
  if (options_.clock_trusted) ephemeris = sun_position(utc, site_).direction;
  return cross_check(ephemeris, find_sun(picture, observer_.camera()), options_.clock_trusted);
}

Result<SkyReport> SkyWatch::observe(const Frame& frame) {
  auto decoded = decode(frame, observer_.camera().yuv_encoding);
  if (!decoded) return fail(decoded.error());
  const auto picture = sky_picture(decoded->view(), observer_.camera());
  if (!picture) return fail(picture.error());

  SkyReport report;
  report.utc = frame.metadata.utc;
  report.picture = std::make_shared<const DecodedPicture>(*decoded);
  report.sun = find_sun_for(report.utc, *picture);
  if (report.sun.source == SunSource::none) {
    report.estimate.reason = "the sun's place is unknown: " + report.sun.words;
  } else {
    report.estimate = observer_.look(*picture, report.sun.direction, options_.estimate).estimate;
  }
  tracker_.observe(report.estimate, frame.metadata.captured_at);
  report.tracked = tracker_.at(frame.metadata.captured_at);
  if (report.tracked) report.air = air_quality(report.tracked->turbidity, site_.altitude_m);
  return report;
}

}  // namespace kasumi
