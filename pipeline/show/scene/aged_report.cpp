#include "pipeline/show/scene/aged_report.hpp"

#include "estimator/sky/sun.hpp"

namespace kasumi {

namespace {

using namespace std::chrono_literals;

constexpr double kEveningSine = 0.1045;  // of the sun's height, 6 degrees: warm light, long shadows
constexpr auto kEveningStep = 5min;      // the sun moves by one degree at most

}  // namespace

SkyReport aged(SkyReport report, Duration later, const Installation& installation) {
  if (later <= Duration::zero()) return report;
  report.utc += later;
  if (auto& air = report.air) {
    if (!installation.surroundings.air.whole()) {  // what is given does not age
      air->age += later;
      air->trustworthy = air->trustworthy && air->age <= TrackingRules{}.trusted_for;
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

Utc time_of(BuildingView hour, Utc now, const Site& site) {
  const auto by_the_sun =
      std::chrono::duration_cast<Duration>(std::chrono::duration<double>(240.0 * site.longitude_deg));
  const Utc noon = std::chrono::floor<std::chrono::days>(now + by_the_sun) + 12h - by_the_sun;
  if (hour == BuildingView::noon) return noon;
  const auto height_at = [&](Utc time) { return sun_position(time, site).direction.z; };
  Utc found = noon;
  double lowest = height_at(noon);
  for (Duration away = kEveningStep; away <= 12h && lowest > kEveningSine; away += kEveningStep) {
    const Utc time = hour == BuildingView::morning ? noon - away : noon + away;
    if (const double height = height_at(time); height < lowest) {
      lowest = height;
      found = time;
    }
  }
  return found;
}

SkyReport lit_for(BuildingView view, SkyReport report, const Site& site) {
  if (view == BuildingView::live || view == BuildingView::alone || report.sun.source == SunSource::none) return report;
  if (is_another_hour(view)) report.sun.direction = sun_position(time_of(view, report.utc, site), site).direction;
  report.measured = nullptr;  // clouds of now
  report.estimate.sky = SkyCondition::clear;
  return report;
}

}  // namespace kasumi
