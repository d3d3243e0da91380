#include "pipeline/show/scene/aged_report.hpp"

#include "estimator/sky/sun.hpp"

namespace kasumi {

namespace {

using namespace std::chrono_literals;

constexpr double kEveningSine = 0.1045;  // of the sun's height, 6 degrees: warm light, long shadows
constexpr auto kEveningStep = 5min;      // the sun moves by one degree at most

// The first time after this day's noon at which the sun is that low; where it never is, when it is lowest.
Direction evening_sun(Utc utc, const Site& site) {
  const auto by_the_sun =
      std::chrono::duration_cast<Duration>(std::chrono::duration<double>(240.0 * site.longitude_deg));
  const Utc noon = std::chrono::floor<std::chrono::days>(utc + by_the_sun) + 12h - by_the_sun;
  Direction lowest = sun_position(noon, site).direction;
  for (Duration later = kEveningStep; later <= 12h && lowest.z > kEveningSine; later += kEveningStep) {
    const Direction sun = sun_position(noon + later, site).direction;
    if (sun.z < lowest.z) lowest = sun;
  }
  return lowest;
}

}  // namespace

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

SkyReport lit_for(BuildingView view, SkyReport report, const Site& site) {
  if (view == BuildingView::live || view == BuildingView::alone || report.sun.source == SunSource::none) return report;
  if (view == BuildingView::evening) report.sun.direction = evening_sun(report.utc, site);
  report.measured = nullptr;  // clouds of now
  report.estimate.sky = SkyCondition::clear;
  return report;
}

}  // namespace kasumi
