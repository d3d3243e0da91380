// How a visitor may see the building, besides as it stands in the camera's picture now.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "pipeline/show/scene/sky_watch.hpp"

namespace kasumi {

enum class BuildingView {
  live,
  alone,      // all around it dimmed
  clear_air,  // in the clear air of kClearAir, whatever the air is
  evening,    // under the sun of this evening, in the air of now; all around it dimmed, since that is of now
};
constexpr std::array<std::string_view, 4> kBuildingViewNames{"live", "alone", "clear_air", "evening"};
constexpr std::size_t kBuildingViews = kBuildingViewNames.size();
constexpr Turbidity kClearAir{2.0};  // a clear day in the mountains (Preetham 1999, Fig 3)

// Whether the camera's picture around the building is dimmed.
constexpr bool is_dimmed(BuildingView view) {
  return view == BuildingView::alone || view == BuildingView::evening;
}
// The same report with the sky in which that view is lit. A view of the same light is left as it is.
SkyReport lit_for(BuildingView view, SkyReport report, const Site& site);

}  // namespace kasumi
