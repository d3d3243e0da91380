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
  // Under the sun of another hour of this day, in the air of now; all around it dimmed, since that is of now.
  morning,
  noon,
  evening,
};
constexpr std::array<std::string_view, 6> kBuildingViewNames{"live",    "alone", "clear_air",
                                                             "morning", "noon",  "evening"};
constexpr std::size_t kBuildingViews = kBuildingViewNames.size();

constexpr bool is_another_hour(BuildingView view) {
  return view == BuildingView::morning || view == BuildingView::noon || view == BuildingView::evening;
}

// Whether the camera's picture around the building is dimmed.
constexpr bool is_dimmed(BuildingView view) {
  return view == BuildingView::alone || is_another_hour(view);
}

}  // namespace kasumi
