#include "pipeline/show/scene/aged_report.hpp"

#include "estimator/sky/sun.hpp"

namespace kasumi {

namespace {

template <class Tracked>
void age_tracked(std::optional<Tracked>& tracked, Duration later, Duration trusted_for) {
  if (!tracked) return;
  tracked->age += later;
  tracked->trustworthy = tracked->trustworthy && tracked->age <= trusted_for;
}

}  // namespace

SkyReport aged(SkyReport report, Duration later, const Installation& installation) {
  if (later <= Duration::zero()) return report;
  report.utc += later;
  age_tracked(report.by_sky, later, TrackerOptions{}.trusted_for);
  if (!installation.surroundings.air.whole()) {  // what is given does not age
    age_tracked(report.tracked, later, AirTrackerOptions{}.trusted_for);
    age_tracked(report.state, later, AirTrackerOptions{}.trusted_for);
  }
  if (report.state)
    for (auto& part : report.state->observers) part.age += later;
  if (later > kCloudsHold) report.measured = nullptr;
  if (report.sun.source == SunSource::ephemeris)
    report.sun.direction = sun_position(report.utc, installation.site).direction;
  if (report.sun.source == SunSource::image && later > kSunHold) {
    report.sun = {};
    report.sun.message = "the sun was seen too long ago";
  }
  return report;
}

}  // namespace kasumi
