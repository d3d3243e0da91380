// The state of the air in words.
#include <cmath>

#include <fmt/format.h>

#include "estimator/fusion/air_tracker.hpp"

namespace kasumi {
namespace {

constexpr double kWorthNaming = 0.05;                // share
constexpr Duration kNow = std::chrono::minutes(10);  // as AirTracker's kStillNow: no age is named below
constexpr double kUnlikeColumn = 1.25;               // chosen: a smaller factor is within near_ground's own sigma

std::string name_and_age(const ObserverPart& part) {
  if (part.age <= kNow) return std::string(name_of(part.by));
  const double minutes = to_seconds(part.age) / 60.0;
  return minutes < 90.0 ? fmt::format("{} {:.0f} min ago", name_of(part.by), minutes)
                        : fmt::format("{} {:.0f} h ago", name_of(part.by), minutes / 60.0);
}

}  // namespace

std::string TrackedAir::text() const {
  const double aod = air.aerosol().aod_550, sigma = std::sqrt(air.covariance().aod_550);
  if (supposed) return fmt::format("the air is supposed: aerosol {:.2f}, T {:.1f}", aod, air.turbidity().value);
  std::string by;
  for (const ObserverPart& part : observers)
    if (part.share >= kWorthNaming) by += (by.empty() ? " by " : " and ") + name_and_age(part);
  std::string text = air.aerosol_known() ? fmt::format("aerosol {:.2f} +- {:.2f}", aod, sigma)
                                         : fmt::format("T {:.2f} +- {:.2f}", air.turbidity().value, sigma_turbidity);
  text += by;
  const double near = air.near_ground();
  if (near > kUnlikeColumn || near < 1.0 / kUnlikeColumn)
    text += fmt::format("; near the ground {:.1f} times as much", near);
  return text;
}

}  // namespace kasumi
