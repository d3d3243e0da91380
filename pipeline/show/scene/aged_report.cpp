#include "pipeline/show/scene/aged_report.hpp"

#include "estimator/sky/sun.hpp"

namespace kasumi {

SkyReport aged(SkyReport report, Duration later, const Installation& installation) {
  if (later <= Duration::zero()) return report;
  report.utc += later;
  if (auto& air = report.air) {
    if (!installation.surroundings.air.whole()) {  // what is given does not age
      air->age += later;
      air->trustworthy = air->trustworthy && air->age <= AirTrackerOptions{}.trusted_for;
    }
    for (auto& part : air->observers) part.age += later;
  }
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
