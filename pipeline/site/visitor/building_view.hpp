// How a visitor may see the building, besides as it stands in the camera's picture now.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

namespace kasumi {

enum class BuildingView {
  live,
  alone,      // all around it dimmed
  clear_air,  // in the air of a clear day, whatever the air is
  evening,    // under the sun of this evening, in the air of now; all around it dimmed, since that is of now
};
constexpr std::array<std::string_view, 4> kBuildingViewNames{"live", "alone", "clear_air", "evening"};
constexpr std::size_t kBuildingViews = kBuildingViewNames.size();

// Whether the camera's picture around the building is dimmed.
constexpr bool is_dimmed(BuildingView view) {
  return view == BuildingView::alone || view == BuildingView::evening;
}

}  // namespace kasumi
