#include "gles/light/airlight_grid.hpp"

#include <algorithm>
#include <cmath>

namespace kasumi {
namespace {

// Grid points per pixel; a grid without extent is constant.
glm::dvec2 points_per_pixel(const AirlightGrid& grid) {
  const glm::dvec2 extent = grid.last_px - grid.first_px;
  return {extent.x > 0.0 ? (AirlightGrid::kColumns - 1) / extent.x : 0.0,
          extent.y > 0.0 ? (AirlightGrid::kRows - 1) / extent.y : 0.0};
}

}  // namespace

glm::dvec3 airlight_at(const AirlightGrid& grid, const glm::dvec2& pixel) {
  return AirlightRow(grid, pixel.y).at(pixel.x);
}

AirlightRow::AirlightRow(const AirlightGrid& grid, double pixel_y)
    : first_px_(grid.first_px.x), points_per_px_(points_per_pixel(grid).x) {
  const double y = std::clamp((pixel_y - grid.first_px.y) * points_per_pixel(grid).y, 0.0, AirlightGrid::kRows - 1.0);
  const int row = std::min(static_cast<int>(y), AirlightGrid::kRows - 2);
  share_below_ = y - row;
  above_ = grid.light.data() + row * AirlightGrid::kColumns;
}

glm::dvec3 AirlightRow::at(double pixel_x) const {
  const double x = std::clamp((pixel_x - first_px_) * points_per_px_, 0.0, AirlightGrid::kColumns - 1.0);
  const int column = std::min(static_cast<int>(x), AirlightGrid::kColumns - 2);
  const double fx = x - column, fy = share_below_;
  const glm::dvec3 *above = above_ + column, *below = above + AirlightGrid::kColumns;
  return (1.0 - fy) * ((1.0 - fx) * above[0] + fx * above[1]) + fy * ((1.0 - fx) * below[0] + fx * below[1]);
}

void check(const AirlightGrid& grid, std::string_view name, bool positive, Problems& problems) {
  const auto finite = [](const glm::dvec2& v) { return std::isfinite(v.x) && std::isfinite(v.y); };
  if (!finite(grid.first_px) || !finite(grid.last_px) || grid.last_px.x < grid.first_px.x ||
      grid.last_px.y < grid.first_px.y)
    problems.add("{}: corners ({}, {}) and ({}, {}): expected finite pixels, the last right of and below the first",
                 name, grid.first_px.x, grid.first_px.y, grid.last_px.x, grid.last_px.y);
  if (!std::isfinite(grid.saturation) || grid.saturation <= 0.0)
    problems.add("{}: saturation {}: expected a finite number > 0", name, grid.saturation);
  for (std::size_t i = 0; i < grid.light.size(); ++i)
    for (int c = 0; c < 3; ++c)
      if (const double value = grid.light[i][c]; !std::isfinite(value) || value < 0.0 || (positive && value <= 0.0)) {
        problems.add("{}: light[{}] channel {} = {}: expected a finite number {} 0", name, i, c, value,
                     positive ? ">" : ">=");
        return;
      }
}

void set_airlight(const Program& program, const std::string& name, const AirlightGrid& grid) {
  const glm::dvec2 scale = points_per_pixel(grid);
  program.set(name + "_light", grid.light);
  program.set(name + "_place", glm::dvec4(grid.first_px, scale));
  if (grid.saturates()) program.set("saturation", grid.saturation);
}

}  // namespace kasumi
