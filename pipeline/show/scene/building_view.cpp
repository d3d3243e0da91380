#include "pipeline/show/scene/building_view.hpp"

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

SkyReport lit_for(BuildingView view, SkyReport report, const Site& site) {
  if (view == BuildingView::live || view == BuildingView::alone || report.sun.source == SunSource::none) return report;
  if (view == BuildingView::evening) report.sun.direction = evening_sun(report.utc, site);
  report.measured = nullptr;  // clouds of now
  report.estimate.sky = SkyCondition::clear;
  return report;
}

}  // namespace kasumi
