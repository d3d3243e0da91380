// A report of the sky, updated for the time since it was made, to be shown while the sky's loop is silent.
#pragma once

#include "pipeline/show/scene/sky_watch.hpp"
#include "pipeline/site/config/installation.hpp"
#include "pipeline/site/visitor/building_view.hpp"

namespace kasumi {

constexpr Duration kCloudsHold = std::chrono::minutes(2);  // longer than between two pictures of a slow camera; older
                                                           // clouds have moved on
constexpr Duration kSunHold = std::chrono::minutes(10);    // of a sun seen in the picture: it moves 2.5 deg meanwhile

// What is known of the air has grown older and is trusted as long as ever, the sun has moved on, seen clouds and a seen
// sun hold for a while. Only the widths of what drifts stay as they were. `later` >= 0, else it counts as 0.
SkyReport aged(SkyReport report, Duration later, const Installation& installation);

// When that hour of this day is: the first time after noon at which the sun stands 6 degrees high, the last one before it,
// or noon by the mean sun. Where it never stands so low, when it is lowest.
Utc time_of(BuildingView hour, Utc now, const Site& site);

// The same report with the sky in which that view is lit. A view of the same light is left as it is.
SkyReport lit_for(BuildingView view, SkyReport report, const Site& site);

}  // namespace kasumi
